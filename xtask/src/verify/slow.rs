//! Slow tests, parsed from the output of the test runners: pytest reports each test, cargo each
//! test program.

/// A test, or all tests of a program, and its time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slow {
    pub(super) seconds: f32,
    pub(super) what: String,
}

/// The tests in a log of a check, in order.
pub(super) fn in_output(output: &str) -> Vec<Slow> {
    let mut found = Vec::new();
    let mut program = "";
    for line in output.lines() {
        let line = line.trim();
        if let Some(begun) = line.strip_prefix("Running ") {
            program = begun.split(" (").next().unwrap_or(begun);
        } else if let Some(begun) = line.strip_prefix("Doc-tests ") {
            program = begun;
        } else if let Some((_, took)) = line.split_once("; finished in ") {
            let took = took.trim_end_matches('s');
            found.extend(slow(took, &format!("all of {program}")));
        } else if let Some((took, rest)) = line.split_once("s ") {
            for phase in ["setup", "call", "teardown"] {
                // Names of tests with parameters may have blanks.
                if let Some(test) = rest.trim_start().strip_prefix(phase) {
                    found.extend(slow(took, &format!("{} ({phase})", test.trim_start())));
                }
            }
        }
    }
    found
}

/// `12.3` as a number.
fn slow(took: &str, what: &str) -> Option<Slow> {
    let seconds = took.parse().ok()?;
    Some(Slow {
        seconds,
        what: what.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::in_output;

    #[test]
    fn cargo_tells_of_programs_and_pytest_of_tests() {
        let output = "     Running tests/a.rs (target/debug/deps/a-1)\n\
                      test result: ok. 3 passed; 0 failed; finished in 1.25s\n   Doc-tests nsrm\n\
                      test result: ok. 1 passed; 0 failed; finished in 0.50s\n\
                      ===== slowest 20 durations =====\n\
                      46.47s setup    sim-harness/tests/test_a.py::test_b\n\
                      1.02s call     sim-harness/tests/test_a.py::test_c[1 of 2]\n";
        let told: Vec<_> = in_output(output)
            .into_iter()
            .map(|slow| (slow.seconds, slow.what))
            .collect();
        let expected = [
            (1.25, "all of tests/a.rs"),
            (0.5, "all of nsrm"),
            (46.47, "sim-harness/tests/test_a.py::test_b (setup)"),
            (1.02, "sim-harness/tests/test_a.py::test_c[1 of 2] (call)"),
        ];
        assert_eq!(told, expected.map(|(took, what)| (took, what.to_owned())));
    }
}
