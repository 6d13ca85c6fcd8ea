//! The time that all processes of a robot share.

use core::sync::atomic::{AtomicBool, Ordering};

use rustix::time::{ClockId, clock_gettime};

/// Whose time a process goes by: the same for all processes of a robot, or they refuse each
/// other's scenes and commands as too old or of the future.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clock {
    /// The machine's monotonic one (`CLOCK_MONOTONIC`; Python's `time.monotonic_ns`), which is
    /// the same for every process on it and never set back.
    #[default]
    Machine,
    /// The wall clock (`CLOCK_REALTIME`; Python's `time.time_ns`), which several hosts keep
    /// equal by PTP or NTP. Where it is set, scenes and commands under way are refused; where it
    /// is set back, a planner that is started anew numbers its plans below those that the
    /// controller has had, which answers that they are impossible: start that one anew, too.
    Wall,
}

static IS_WALL: AtomicBool = AtomicBool::new(false);

/// Makes this process go by another clock than the machine's; to be called before anything
/// is timed.
pub fn go_by(clock: Clock) {
    IS_WALL.store(clock == Clock::Wall, Ordering::Relaxed);
}

/// Nanoseconds on the clock that this process goes by.
pub fn now_ns() -> u64 {
    let clock = if IS_WALL.load(Ordering::Relaxed) {
        ClockId::Realtime
    } else {
        ClockId::Monotonic
    };
    let time = clock_gettime(clock);
    // Positive, and centuries fit.
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
