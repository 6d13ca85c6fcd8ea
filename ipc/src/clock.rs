//! The time that all processes of a robot share.

use core::sync::atomic::{AtomicBool, Ordering};

use rustix::time::{ClockId, clock_gettime};

/// The clock of a process. All processes of a robot must use the same one, or they refuse each
/// other's scenes and commands as too old or from the future.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Clock {
    /// The machine's monotonic clock (`CLOCK_MONOTONIC`; Python's `time.monotonic_ns`), which all
    /// its processes share and which is never set back.
    #[default]
    Machine,
    /// The wall clock (`CLOCK_REALTIME`; Python's `time.time_ns`), which several hosts synchronize
    /// by PTP or NTP. If it is set, current scenes and commands are refused. If it is set back, a
    /// restarted planner numbers its plans below those that the controller has received, which
    /// answers that they are impossible: restart the controller, too.
    Wall,
}

static IS_WALL: AtomicBool = AtomicBool::new(false);

/// Sets the clock of this process; call it before the first use of the time.
///
/// ```standalone_crate
/// use nsrm_ipc::clock::{Clock, now_ns, set_clock};
///
/// set_clock(Clock::Wall); // for a robot on several hosts
/// assert!(now_ns() > 0);
/// ```
pub fn set_clock(clock: Clock) {
    IS_WALL.store(clock == Clock::Wall, Ordering::Relaxed);
}

/// Whether a periodic task is due. A longer wait than its period means that the clock was set back.
pub const fn is_due(next_ns: u64, now_ns: u64, every_ns: u64) -> bool {
    let waits_ns = next_ns.saturating_sub(now_ns);
    waits_ns == 0 || waits_ns > every_ns
}

/// The time on this process's clock, nanoseconds.
pub fn now_ns() -> u64 {
    let clock = if IS_WALL.load(Ordering::Relaxed) {
        ClockId::Realtime
    } else {
        ClockId::Monotonic
    };
    let time = clock_gettime(clock);
    // Positive, and fits for centuries.
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
