//! Counts the messages that a node has rejected, because they were invalid or too late.

use core::fmt::Display;

use tracing::warn;

use crate::clock::is_due;

/// The shortest time between two log lines about rejected messages, nanoseconds: a flood of invalid
/// messages must not fill the log.
const BETWEEN_LINES_NS: u64 = 1_000_000_000;

/// How many messages a node has rejected.
#[derive(Debug, Default)]
pub(super) struct Rejected {
    count: u64,
    /// When the next one can be logged.
    next_line_ns: u64,
}

impl Rejected {
    /// Counts one more and logs it, unless another one was just logged. Does not allocate itself.
    pub(super) fn add(&mut self, service: &str, why: &dyn Display, now_ns: u64) {
        self.count = self.count.saturating_add(1);
        if is_due(self.next_line_ns, now_ns, BETWEEN_LINES_NS) {
            self.next_line_ns = now_ns.saturating_add(BETWEEN_LINES_NS);
            warn!(service, %why, rejected = self.count, "message rejected");
        }
    }

    /// How many there were.
    pub(super) const fn count(&self) -> u64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_counted_and_one_a_second_is_logged() {
        let mut rejected = Rejected::default();
        // Then the clock is set back.
        let lines: Vec<_> = [0, 1, 999_999_999, 1_000_000_000, 1_000_000_001, 5, 6]
            .into_iter()
            .filter(|now_ns| {
                let before_ns = rejected.next_line_ns;
                rejected.add("scene", &"no scene", *now_ns);
                rejected.next_line_ns != before_ns
            })
            .collect();
        assert_eq!(lines, [0, 1_000_000_000, 5]);
        assert_eq!(rejected.count(), 7);
    }
}
