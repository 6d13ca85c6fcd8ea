//! Checks that shared memory has free space. Linux allocates a page on the first write, and kills
//! the writer by SIGBUS without a message if none is left; so each process checks before it starts.

use super::leftovers::SEGMENTS;
use super::{RobotName, ServiceError};

/// An error if fewer bytes are left than needed.
pub(super) fn find_room(
    robot: &RobotName,
    service: &'static str,
    wanted: u64,
) -> Result<(), ServiceError> {
    // If the check itself fails, the process may try.
    let Ok(found) = rustix::fs::statvfs(SEGMENTS) else {
        return Ok(());
    };
    let free = found.f_bavail.saturating_mul(found.f_frsize);
    // A file system without blocks has no limit.
    if found.f_blocks == 0 || free >= wanted {
        return Ok(());
    }
    Err(ServiceError::NoRoom {
        robot: robot.clone(),
        service,
        free,
        wanted,
    })
}
