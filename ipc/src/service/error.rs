use core::fmt;
use std::path::PathBuf;

use super::RobotName;
use super::leftovers::SEGMENTS;

/// Why a service can't be used.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum ServiceError {
    /// Another process has the place that only one may have.
    Taken {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
        /// The process, if it could be found.
        process: Option<u32>,
    },
    /// All places are taken.
    Full {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
    },
    /// Someone uses the service with another layout of its messages or other
    /// promises.
    OtherVersion {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
    },
    /// Where the processes meet belongs to another user.
    OtherUser {
        /// Of which robot.
        robot: RobotName,
        /// Which service; `node` before any is used.
        service: &'static str,
        /// The folder by which they meet.
        folder: PathBuf,
    },
    /// Shared memory has too little left.
    NoRoom {
        /// Of which robot.
        robot: RobotName,
        /// Which service; `node` before any is used.
        service: &'static str,
        /// Bytes that are left.
        free: u64,
        /// Bytes that must be.
        wanted: u64,
    },
    /// Anything else that iceoryx2 says.
    Iceoryx {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
        /// What it says.
        says: String,
        /// Why, and what to do, if that could be found.
        cause: Option<String>,
    },
}

/// Why a message was not sent.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum SendFailure {
    /// The receiver has not taken those before it.
    Full,
    /// Anything else that iceoryx2 says.
    Iceoryx(String),
}

impl fmt::Display for SendFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str(
                "the receiver does not take its messages: does it hang? Stop it and start it anew",
            ),
            Self::Iceoryx(says) => write!(f, "the message was not sent: {says}"),
        }
    }
}

impl core::error::Error for SendFailure {}

impl fmt::Display for ServiceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taken {
                robot,
                service,
                process,
            } => {
                write!(f, "robot `{robot}`: `{service}` is already served")?;
                if let Some(process) = process {
                    write!(f, " by process {process}")?;
                }
                f.write_str("; choose another name, or stop it")
            }
            Self::Full { robot, service } => write!(
                f,
                "robot `{robot}`: too many processes use `{service}`; stop one of them"
            ),
            Self::OtherVersion { robot, service } => write!(
                f,
                "robot `{robot}`: another version of NSRM uses `{service}`, or a process that was \
                 told of another number of hosts; use the same version and the same `hosts` for \
                 all of a robot's processes, and a tunnel with the configuration in docs/hosts"
            ),
            Self::OtherUser { robot, folder, .. } => write!(
                f,
                "robot `{robot}`: its processes meet in {}, which belongs to another user; start \
                 all of them as that one, or give this robot a folder of its own: `root` under \
                 [shared_memory] in a configuration",
                folder.display()
            ),
            Self::NoRoom {
                robot,
                service,
                free,
                wanted,
            } => {
                let megabytes = |bytes: u64| bytes as f64 / 1e6;
                write!(
                    f,
                    "robot `{robot}`: `{service}` wants {:.1} MB of shared memory, and {:.1} are \
                     left in {SEGMENTS}; remove what nobody uses there, or enlarge it (`mount -o \
                     remount,size=...`; for a container `--shm-size`)",
                    megabytes(*wanted),
                    megabytes(*free),
                )
            }
            Self::Iceoryx {
                robot,
                service,
                says,
                cause,
            } => {
                write!(f, "robot `{robot}`: `{service}`: {says}")?;
                if let Some(cause) = cause {
                    write!(f, ": {cause}")?;
                }
                Ok(())
            }
        }
    }
}

impl core::error::Error for ServiceError {}
