//! The report at the end.

use std::fmt::Write;

use super::checks::CHECKS;
use super::count::Counts;
use super::slow::Slow;

/// The result of a check.
pub(super) struct Outcome {
    pub(super) name: &'static str,
    pub(super) failed: bool,
    pub(super) counts: Counts,
    pub(super) seconds: f32,
    /// Processor time, seconds, without that of an environment that it set up.
    pub(super) processor: f32,
    pub(super) slow: Vec<Slow>,
}

/// How many slow tests are listed.
const LISTED: usize = 15;
/// Shorter tests are not listed, seconds.
const SLOW_S: f32 = 5.0;

impl Outcome {
    /// One line for the end of the check.
    pub(super) fn line(&self) -> String {
        format!(
            "{} in {:.1} s: {} passed, {} failed, {} skipped",
            self.verdict(),
            self.seconds,
            self.counts.passed,
            self.counts.failed,
            self.counts.skipped
        )
    }

    fn verdict(&self) -> &'static str {
        if self.failed { "FAILED" } else { "passed" }
    }
}

/// All checks of a run.
#[derive(Default)]
pub(super) struct Report(Vec<Outcome>);

impl Report {
    pub(super) fn add(&mut self, outcome: Outcome) {
        self.0.push(outcome);
    }

    pub(super) fn passed(&self) -> bool {
        self.0.iter().all(|outcome| !outcome.failed)
    }

    /// A row a check, in their usual order, then the slow tests, what was checked and how many
    /// tests passed.
    ///
    /// * `seconds`: of the whole run, in which checks may have run beside each other
    pub(super) fn table(&self, seconds: f32) -> String {
        let mut outcomes: Vec<_> = self.0.iter().collect();
        outcomes.sort_by_key(|outcome| CHECKS.iter().position(|check| check.name == outcome.name));
        let mut text = format!(
            "{:<14} {:>8} {:>8} {:>8} {:>8} {:>9} {:>10}\n",
            "check", "result", "passed", "failed", "skipped", "seconds", "processor"
        );
        let mut all = Counts::default();
        for outcome in &outcomes {
            let counts = outcome.counts;
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{:<14} {:>8} {:>8} {:>8} {:>8} {:>9.1} {:>10.1}",
                outcome.name,
                outcome.verdict(),
                counts.passed,
                counts.failed,
                counts.skipped,
                outcome.seconds,
                outcome.processor
            );
            all.add(counts);
        }
        let mut slow: Vec<_> = outcomes.iter().flat_map(|outcome| &outcome.slow).collect();
        slow.retain(|slow| slow.seconds >= SLOW_S);
        slow.sort_by(|one, other| other.seconds.total_cmp(&one.seconds));
        if !slow.is_empty() {
            let _ = writeln!(text, "\nslowest tests, seconds:");
        }
        for Slow { seconds, what } in slow.into_iter().take(LISTED) {
            let _ = writeln!(text, "{seconds:>9.1}  {what}");
        }
        let names: Vec<_> = outcomes.iter().map(|outcome| outcome.name).collect();
        let failed: Vec<_> = outcomes.iter().filter(|outcome| outcome.failed).collect();
        let processor: f32 = outcomes.iter().map(|outcome| outcome.processor).sum();
        let _ = writeln!(
            text,
            "\nchecked in {:.0} min {:.0} s, {:.0} min of processor time: {}",
            (seconds / 60.0).floor(),
            seconds % 60.0,
            processor / 60.0,
            names.join(", ")
        );
        if !failed.is_empty() {
            let failed: Vec<_> = failed.iter().map(|outcome| outcome.name).collect();
            let _ = writeln!(text, "failed: {}", failed.join(", "));
        }
        if all.skipped > 0 {
            let _ = writeln!(
                text,
                "skipped: {} tests; the logs give the reasons",
                all.skipped
            );
        }
        let _ = write!(text, "verify: {} passed, {} failed", all.passed, all.failed);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::{Counts, Outcome, Report, Slow};

    #[test]
    fn the_last_line_adds_all_checks_up() {
        let mut report = Report::default();
        for (name, passed, failed) in [("format", 1, 0), ("rust-tests", 40, 2)] {
            report.add(Outcome {
                name,
                failed: failed > 0,
                counts: Counts {
                    passed,
                    failed,
                    skipped: 0,
                },
                seconds: 35.0,
                processor: 60.0,
                slow: [(4.0, "quick"), (6.0, "slow"), (50.0, "slowest")]
                    .map(|(seconds, what)| Slow {
                        seconds,
                        what: format!("{what} of {name}"),
                    })
                    .to_vec(),
            });
        }
        let table = report.table(70.0);
        assert!(!report.passed());
        assert!(table.ends_with("failed: rust-tests\nverify: 41 passed, 2 failed"));
        assert!(table.contains("checked in 1 min 10 s, 2 min of processor time: format"));
        let listed =
            "     50.0  slowest of format\n     50.0  slowest of rust-tests\n      6.0  slow of";
        assert!(table.contains(listed) && !table.contains("quick of"));
    }
}
