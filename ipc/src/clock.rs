//! The time that all processes of a machine share.

use rustix::time::{ClockId, clock_gettime};

/// Nanoseconds on the machine's monotonic clock (`CLOCK_MONOTONIC`; Python's
/// `time.monotonic_ns`), which is the same for every process and never set back.
pub fn now_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    // Positive, and centuries fit.
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
