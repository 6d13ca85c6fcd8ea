//! What the checks came to.

use std::fmt::Write;

use super::count::Counts;

/// How a check ended.
pub(super) struct Outcome {
    pub(super) name: &'static str,
    pub(super) failed: bool,
    pub(super) counts: Counts,
    pub(super) seconds: f32,
}

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

/// All checks of a run, in their order.
#[derive(Default)]
pub(super) struct Report(Vec<Outcome>);

impl Report {
    pub(super) fn add(&mut self, outcome: Outcome) {
        self.0.push(outcome);
    }

    pub(super) fn passed(&self) -> bool {
        self.0.iter().all(|outcome| !outcome.failed)
    }

    /// A row a check, then what was checked and how many tests passed.
    pub(super) fn table(&self) -> String {
        let mut text = format!(
            "{:<14} {:>8} {:>8} {:>8} {:>8} {:>9}\n",
            "check", "result", "passed", "failed", "skipped", "seconds"
        );
        let mut all = Counts::default();
        let mut seconds = 0.0;
        for outcome in &self.0 {
            let counts = outcome.counts;
            // Writing to a String can't fail.
            let _ = writeln!(
                text,
                "{:<14} {:>8} {:>8} {:>8} {:>8} {:>9.1}",
                outcome.name,
                outcome.verdict(),
                counts.passed,
                counts.failed,
                counts.skipped,
                outcome.seconds
            );
            all.add(counts);
            seconds += outcome.seconds;
        }
        let names: Vec<_> = self.0.iter().map(|outcome| outcome.name).collect();
        let failed: Vec<_> = self.0.iter().filter(|outcome| outcome.failed).collect();
        let _ = writeln!(
            text,
            "\nchecked in {:.0} min {:.0} s: {}",
            (seconds / 60.0).floor(),
            seconds % 60.0,
            names.join(", ")
        );
        if !failed.is_empty() {
            let failed: Vec<_> = failed.iter().map(|outcome| outcome.name).collect();
            let _ = writeln!(text, "failed: {}", failed.join(", "));
        }
        if all.skipped > 0 {
            let _ = writeln!(text, "skipped: {} tests; the logs say why", all.skipped);
        }
        let _ = write!(text, "verify: {} passed, {} failed", all.passed, all.failed);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::{Counts, Outcome, Report};

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
            });
        }
        let table = report.table();
        assert!(!report.passed());
        assert!(table.ends_with("failed: rust-tests\nverify: 41 passed, 2 failed"));
        assert!(table.contains("checked in 1 min 10 s: format, rust-tests"));
    }
}
