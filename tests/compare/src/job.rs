use std::fmt;
use std::str::FromStr;

use anyhow::{Error, Result, bail};

/// What is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Job {
    /// A sentence of one step and twelve tokens about six objects, to program, objects and location.
    Plan,
    /// Twelve words to the encoder's states.
    Encoder,
    /// Twelve words to the hazard at each.
    Splitter,
    /// An action and two locations to the moved object's location.
    Simulator,
    /// One crop to its embedding.
    Crop,
    /// Six crops to their embeddings.
    Crops,
}

impl Job {
    /// All jobs.
    pub const ALL: [Self; 6] = [
        Self::Plan,
        Self::Encoder,
        Self::Splitter,
        Self::Simulator,
        Self::Crop,
        Self::Crops,
    ];

    /// Its name in tables, files and the protocol.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Encoder => "encoder",
            Self::Splitter => "splitter",
            Self::Simulator => "simulator",
            Self::Crop => "crop",
            Self::Crops => "crops",
        }
    }
}

impl fmt::Display for Job {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for Job {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match Self::ALL.into_iter().find(|job| job.name() == name) {
            Some(job) => Ok(job),
            None => bail!("unknown job {name:?}"),
        }
    }
}
