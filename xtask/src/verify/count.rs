//! How many tests ran, parsed from the output of the test runners.

use anyhow::{Result, bail};

/// Numbers of tests by result.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct Counts {
    /// Passed.
    pub(super) passed: u32,
    /// Failed, or stopped by an error.
    pub(super) failed: u32,
    /// Not run: ignored or skipped.
    pub(super) skipped: u32,
}

impl Counts {
    /// A check without tests.
    pub(super) fn one(passed: bool) -> Self {
        Self {
            passed: u32::from(passed),
            failed: u32::from(!passed),
            skipped: 0,
        }
    }

    /// Adds others to these.
    pub(super) fn add(&mut self, others: Self) {
        self.passed += others.passed;
        self.failed += others.failed;
        self.skipped += others.skipped;
    }
}

/// Who printed the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Runner {
    /// `cargo test`: a `test result:` line a binary.
    Cargo,
    /// `pytest`: one summary line at the end.
    Pytest,
    /// libFuzzer: one line when the time is over and nothing was found.
    Fuzz,
}

/// Sums the counts in a runner's output. No tests at all is an error, since a check that
/// proves nothing must not pass.
pub(super) fn in_output(runner: Runner, output: &str) -> Result<Counts> {
    let mut counts = Counts::default();
    match runner {
        Runner::Cargo => {
            for line in output.lines() {
                if let Some((_, rest)) = line.split_once("test result: ") {
                    counts.add(in_line(rest));
                }
            }
        }
        Runner::Pytest => {
            let summary = output.lines().rev().find(|line| line.contains(" in "));
            counts = in_line(summary.unwrap_or_default());
        }
        Runner::Fuzz => {
            let ended = |line: &&str| line.starts_with("Done ") && line.contains(" runs in ");
            counts.passed = output.lines().filter(ended).count() as u32;
        }
    }
    if counts.passed + counts.failed == 0 {
        bail!("no tests ran");
    }
    Ok(counts)
}

/// `12 passed; 1 failed`, in any order and with any marks between.
fn in_line(line: &str) -> Counts {
    let mut counts = Counts::default();
    let mut number: Option<u32> = None;
    for word in line.split(|letter: char| !letter.is_alphanumeric()) {
        match (word, number) {
            ("passed", Some(count)) => counts.passed += count,
            ("failed" | "error" | "errors", Some(count)) => counts.failed += count,
            ("ignored" | "skipped" | "xfailed", Some(count)) => counts.skipped += count,
            _ => {}
        }
        number = word.parse().ok();
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::{Counts, Runner, in_output};

    #[test]
    fn cargo_prints_a_line_for_each_binary() {
        let output = "running 3 tests\ntest result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; \
                      0 filtered out; finished in 0.01s\n\ntest result: FAILED. 1 passed; 2 failed; \
                      0 ignored; 0 measured; 5 filtered out\n";
        let expected = Counts {
            passed: 4,
            failed: 2,
            skipped: 1,
        };
        assert_eq!(in_output(Runner::Cargo, output).unwrap(), expected);
    }

    #[test]
    fn pytest_prints_one_line_at_the_end() {
        let output = "tests/test_a.py ..\n1 failed, 12 passed, 2 skipped, 1 error in 3.21s\n";
        let expected = Counts {
            passed: 12,
            failed: 2,
            skipped: 2,
        };
        assert_eq!(in_output(Runner::Pytest, output).unwrap(), expected);
    }

    #[test]
    fn libfuzzer_prints_one_line_when_nothing_was_found() {
        let output = "#2\tINITED cov: 61\nDone 1443 runs in 61 second(s)\n";
        let expected = Counts {
            passed: 1,
            ..Counts::default()
        };
        assert_eq!(in_output(Runner::Fuzz, output).unwrap(), expected);
        assert!(in_output(Runner::Fuzz, "SUMMARY: libFuzzer: deadly signal").is_err());
    }

    #[test]
    fn a_run_without_tests_does_not_pass() {
        let none = "test result: ok. 0 passed; 0 failed; 9 ignored; 0 measured";
        assert!(in_output(Runner::Cargo, none).is_err());
        assert!(in_output(Runner::Pytest, "no tests ran in 0.01s").is_err());
        assert!(in_output(Runner::Cargo, "").is_err());
    }
}
