use core::fmt;
use std::path::PathBuf;

use thiserror::Error;

use super::RobotName;
use super::leftovers::SEGMENTS;

/// Why a process cannot use a service.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ServiceError {
    /// Another process has the service's only slot.
    #[error(fmt = taken)]
    Taken {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
        /// The other process, if it could be found.
        process: Option<u32>,
    },
    /// All slots are taken.
    #[error("robot `{robot}`: too many processes use `{service}`; stop one of them")]
    Full {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
    },
    /// Another process uses the service with a different message layout or different
    /// guarantees.
    #[error(
        "robot `{robot}`: `{service}` is used by another version of NSRM, or by a process with \
         another setting of `hosts`; use the same version and the same `hosts` for all of a \
         robot's processes, and a tunnel with the configuration in docs/hosts"
    )]
    OtherVersion {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
    },
    /// The shared-memory folder belongs to another user.
    #[error(
        "robot `{robot}`: the shared-memory folder {} belongs to another user; start all processes \
         as that user, or give this robot its own folder: `root` under [shared_memory] in the \
         configuration",
        .folder.display()
    )]
    OtherUser {
        /// Of which robot.
        robot: RobotName,
        /// Which service; `node` before any service is opened.
        service: &'static str,
        /// The folder.
        folder: PathBuf,
    },
    /// Too little shared memory is left.
    #[error(
        "robot `{robot}`: `{service}` needs {:.1} MB of shared memory, but {:.1} are left in \
         {SEGMENTS}; remove unused files there, or enlarge it (`mount -o remount,size=...`; for a \
         container `--shm-size`)",
        megabytes(*.wanted),
        megabytes(*.free)
    )]
    NoRoom {
        /// Of which robot.
        robot: RobotName,
        /// Which service; `node` before any service is opened.
        service: &'static str,
        /// Bytes left.
        free: u64,
        /// Bytes needed.
        wanted: u64,
    },
    /// Any other error of iceoryx2.
    #[error(fmt = iceoryx)]
    Iceoryx {
        /// Of which robot.
        robot: RobotName,
        /// Which service.
        service: &'static str,
        /// The error.
        says: String,
        /// Its likely cause and remedy, if one was found.
        cause: Option<String>,
    },
}

/// Why a message was not sent.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SendFailure {
    /// The receiver has not read the earlier messages.
    #[error("the receiver does not read its messages: does it hang? Restart it")]
    Full,
    /// Any other error of iceoryx2.
    #[error("the message was not sent: {0}")]
    Iceoryx(String),
}

fn taken(
    robot: &RobotName,
    service: &&'static str,
    process: &Option<u32>,
    f: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    write!(f, "robot `{robot}`: `{service}` is already served")?;
    if let Some(process) = process {
        write!(f, " by process {process}")?;
    }
    f.write_str("; choose another robot name, or stop that process")
}

fn iceoryx(
    robot: &RobotName,
    service: &&'static str,
    says: &str,
    cause: &Option<String>,
    f: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    write!(f, "robot `{robot}`: `{service}`: {says}")?;
    match cause {
        Some(cause) => write!(f, ": {cause}"),
        None => Ok(()),
    }
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
