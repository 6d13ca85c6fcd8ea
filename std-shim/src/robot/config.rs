//! The configuration file of a robot's processes.

use std::path::PathBuf;

use iceoryx2::config::Config as Iceoryx;
use iceoryx2::prelude::{FileName, Path, SemanticString};
use nsrm_ipc::clock::{Clock, set_clock};
use nsrm_ipc::executive::{Limits, LimitsError};
use nsrm_ipc::node::Transport;
use nsrm_ipc::service::{Hosts, RobotName, RobotNameError, set_global_config};
use serde::Deserialize;
use thiserror::Error;

/// A configuration file (TOML). All keys are optional.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    robot: Option<String>,
    model: Option<PathBuf>,
    transport: Option<TransportFile>,
    hosts: Option<HostsFile>,
    #[serde(default)]
    limits: LimitsFile,
    #[serde(default)]
    shared_memory: SharedMemoryFile,
}

/// [`Transport`] by name.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum TransportFile {
    Connection,
    Broadcast,
}

/// [`Hosts`] by name.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum HostsFile {
    One,
    Several,
}

/// Where iceoryx2 keeps its files and shared memory, if not in the default location.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SharedMemoryFile {
    /// The folder for its files.
    root: Option<String>,
    /// The prefix of names in shared memory.
    prefix: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsFile {
    scene_age_ms: Option<u64>,
    scene_wait_ms: Option<u64>,
    accept_wait_ms: Option<u64>,
    move_wait_ms: Option<u64>,
    silence_ms: Option<u64>,
    tolerance_mm: Option<f32>,
    moved_mm: Option<f32>,
    covered_mm: Option<f32>,
    attempts: Option<u8>,
    retries: Option<u8>,
}

/// The settings of a command.
#[derive(Debug)]
pub(crate) struct Config {
    /// The robot.
    pub(crate) robot: RobotName,
    /// The model file; `None`: the built-in model.
    pub(crate) model: Option<PathBuf>,
    /// The services over which the planner takes requests.
    pub(crate) transport: Transport,
    /// Whether the robot's processes run on one host or several.
    pub(crate) hosts: Hosts,
    /// The limits of the closed loop.
    pub(crate) limits: Limits,
    /// Configuration of iceoryx2: where the processes find each other.
    pub(crate) shared_memory: Iceoryx,
}

/// The default name of the robot.
const ROBOT: &str = "robot";

/// Why a configuration is invalid.
#[derive(Debug, Error)]
pub(crate) enum ConfigError {
    #[error("{path}: {1}", path = .0.display())]
    Read(PathBuf, std::io::Error),
    #[error("{path}: {1}", path = .0.display())]
    Parse(PathBuf, toml::de::Error),
    #[error("{0}")]
    Robot(RobotNameError),
    #[error("limits: {0}")]
    Limits(LimitsError),
    #[error("shared_memory.{0} = {1:?}: too long, or not a valid file name")]
    SharedMemory(&'static str, String),
    #[error(
        "shared_memory.root = {0:?}: must be an absolute path, so that processes find each other \
         wherever they are started"
    )]
    Relative(String),
    #[error("shared_memory: {0}; is {folder} writable?", folder = std::env::temp_dir().display())]
    Settle(std::io::Error),
}

impl Config {
    /// Reads the file, if one is given; options on the command line override it. Also sets the
    /// process's clock to the one that all hosts share.
    pub(crate) fn read(
        path: Option<&PathBuf>,
        robot: Option<&str>,
        model: Option<&PathBuf>,
    ) -> Result<Self, ConfigError> {
        let file = match path {
            None => File::default(),
            Some(path) => {
                let text = std::fs::read_to_string(path)
                    .map_err(|error| ConfigError::Read(path.clone(), error))?;
                toml::from_str(&text).map_err(|error| ConfigError::Parse(path.clone(), error))?
            }
        };
        let robot = robot.or(file.robot.as_deref()).unwrap_or(ROBOT);
        let limits = file.limits.over(Limits::default());
        limits.check().map_err(ConfigError::Limits)?;
        let (hosts, clock) = match file.hosts {
            None | Some(HostsFile::One) => (Hosts::One, Clock::Machine),
            Some(HostsFile::Several) => (Hosts::Several, Clock::Wall),
        };
        set_clock(clock);
        Ok(Self {
            hosts,
            robot: robot.parse().map_err(ConfigError::Robot)?,
            model: model.cloned().or(file.model),
            transport: match file.transport {
                None | Some(TransportFile::Connection) => Transport::Connection,
                Some(TransportFile::Broadcast) => Transport::Broadcast,
            },
            limits,
            shared_memory: file.shared_memory.read()?,
        })
    }
}

impl SharedMemoryFile {
    fn read(&self) -> Result<Iceoryx, ConfigError> {
        if self.root.is_none() && self.prefix.is_none() {
            return Ok(Iceoryx::global_config().clone());
        }
        let mut config = Iceoryx::default();
        if let Some(root) = &self.root {
            if !std::path::Path::new(root).is_absolute() {
                return Err(ConfigError::Relative(root.clone()));
            }
            let path = Path::new(root.as_bytes());
            let path = path.map_err(|_| ConfigError::SharedMemory("root", root.clone()))?;
            config.global.set_root_path(&path);
        }
        if let Some(prefix) = &self.prefix {
            let name = FileName::new(prefix.as_bytes());
            let name = name.map_err(|_| ConfigError::SharedMemory("prefix", prefix.clone()))?;
            config.global.prefix = name;
        }
        set_global_config(&config).map_err(ConfigError::Settle)?;
        Ok(config)
    }
}

impl LimitsFile {
    fn over(&self, limits: Limits) -> Limits {
        let ns = |ms: Option<u64>, default| ms.map_or(default, |ms| ms.saturating_mul(1_000_000));
        let m = |mm: Option<f32>, default| mm.map_or(default, |mm| mm / 1000.0);
        Limits {
            scene_age_ns: ns(self.scene_age_ms, limits.scene_age_ns),
            scene_wait_ns: ns(self.scene_wait_ms, limits.scene_wait_ns),
            accept_wait_ns: ns(self.accept_wait_ms, limits.accept_wait_ns),
            move_wait_ns: ns(self.move_wait_ms, limits.move_wait_ns),
            silence_ns: ns(self.silence_ms, limits.silence_ns),
            tolerance_m: m(self.tolerance_mm, limits.tolerance_m),
            moved_m: m(self.moved_mm, limits.moved_m),
            covered_m: m(self.covered_mm, limits.covered_m),
            attempts: self.attempts.unwrap_or(limits.attempts),
            retries: self.retries.unwrap_or(limits.retries),
        }
    }
}
