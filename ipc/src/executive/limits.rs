use core::fmt;

/// How long is waited, how exact a step must be, how often it is tried again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The oldest scene that is acted upon, nanoseconds since its image was taken.
    pub scene_age_ns: u64,
    /// How long a scene that may be acted upon is waited for.
    pub scene_wait_ns: u64,
    /// How long the controller may take to accept a command, or a stop.
    pub accept_wait_ns: u64,
    /// How long it may take to carry one out.
    pub move_wait_ns: u64,
    /// How long another node may be silent before it is held to be dead.
    pub silence_ns: u64,
    /// How far from its sub-goal an object may be seen, metres.
    pub tolerance_m: f32,
    /// How often anything is tried again, counted over the whole sentence.
    pub retries: u8,
}

impl Default for Limits {
    /// Scenes of half a second at most; three heartbeats lost, so that a death is
    /// noticed within half a second; 15 mm, which is more than an arm may correct a
    /// sub-goal by what it sees of the support (8 mm across and 12 mm in height) and less
    /// than half of the smallest block.
    fn default() -> Self {
        Self {
            scene_age_ns: 500_000_000,
            scene_wait_ns: 2_000_000_000,
            accept_wait_ns: 500_000_000,
            move_wait_ns: 60_000_000_000,
            silence_ns: 350_000_000,
            tolerance_m: 0.015,
            retries: 3,
        }
    }
}

/// A limit that would let nothing happen, or everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LimitsError {
    /// A time is zero.
    Zero(&'static str),
    /// The tolerance is not a positive number.
    Tolerance,
}

impl fmt::Display for LimitsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero(name) => write!(f, "{name}: must be longer than 0"),
            Self::Tolerance => f.write_str("tolerance: must be a positive number of metres"),
        }
    }
}

impl core::error::Error for LimitsError {}

impl Limits {
    /// Whether anything can be done within them.
    pub fn check(&self) -> Result<(), LimitsError> {
        for (name, time) in [
            ("scene age", self.scene_age_ns),
            ("wait for a scene", self.scene_wait_ns),
            ("wait for acceptance", self.accept_wait_ns),
            ("wait for a move", self.move_wait_ns),
            ("silence", self.silence_ns),
        ] {
            if time == 0 {
                return Err(LimitsError::Zero(name));
            }
        }
        if !(self.tolerance_m > 0.0 && self.tolerance_m.is_finite()) {
            return Err(LimitsError::Tolerance);
        }
        Ok(())
    }
}
