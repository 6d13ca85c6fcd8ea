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

/// Whether it is time for what is done once in so long. A longer wait than that shows a clock
/// that was set back.
pub const fn is_due(next_ns: u64, now_ns: u64, every_ns: u64) -> bool {
    let waits_ns = next_ns.saturating_sub(now_ns);
    waits_ns == 0 || waits_ns > every_ns
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

#[cfg(test)]
mod tests {
    use super::is_due;

    #[test]
    fn a_clock_that_is_set_back_holds_nothing_up() {
        for (now_ns, expected) in [
            (99, false),
            (100, true),
            (5000, true),
            (90, false),
            (89, true),
            (0, true),
        ] {
            assert_eq!(is_due(100, now_ns, 10), expected, "{now_ns}");
        }
    }
}
