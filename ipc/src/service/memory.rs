//! Whether shared memory has room. Linux finds a page for it when it is first written to, and
//! ends who writes where none is left by SIGBUS, without a word; so each process looks before
//! it begins.

use super::leftovers::SEGMENTS;
use super::{RobotName, ServiceError};

/// Refuses when fewer bytes are left than are wanted.
pub(super) fn find_room(
    robot: &RobotName,
    service: &'static str,
    wanted: u64,
) -> Result<(), ServiceError> {
    // Who can't look is not kept from trying.
    let Ok(found) = rustix::fs::statvfs(SEGMENTS) else {
        return Ok(());
    };
    let free = found.f_bavail.saturating_mul(found.f_frsize);
    // One without blocks is without a limit.
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
