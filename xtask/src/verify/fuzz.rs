//! The fuzz targets (`tests/fuzz`): the committed inputs on any machine, then new ones
//! for some seconds a target where libFuzzer can be built. CONTRIBUTING says how to fuzz for
//! longer.
//!
//! Without a sanitizer, for which cargo-fuzz needs no nightly toolchain: what is fuzzed
//! has no unsafe code, and overflow and debug assertions are checked.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result};

use super::context::Context;
use super::count::Runner;
use super::step::Step;
use super::tools::Tool;
use crate::project::output_of;

const CARGO_FUZZ: Tool = Tool {
    package: "cargo-fuzz",
    program: "cargo-fuzz",
    version: "0.13.2",
};
/// The package of the targets.
const FOLDER: &str = "tests/fuzz";
/// How long each target is given new inputs, seconds,
const TIME_S: u32 = 10;
/// and how many at most: those that read messages of fixed size take as many in a few seconds, and
/// find nothing new after that.
const INPUTS: u32 = 2_000_000;
/// The longest that one input may take, seconds, before it counts as a find.
const INPUT_S: u32 = 20;

pub(super) fn steps(context: &Context) -> Result<Vec<Step>> {
    let mut steps = vec![Step::rust_tests(&["--test=corpora"])];
    if output_of(Command::new("c++").arg("--version")).is_err() {
        eprintln!(
            "verify: no C++ compiler found, which libFuzzer needs; only committed inputs are tested"
        );
        return Ok(steps);
    }
    let (program, install) = CARGO_FUZZ.at_hand(context);
    steps.extend(install);
    let folder = context.project().target().join("fuzz");
    let fuzz = |arguments: &[&str]| {
        Step::new(&program, &["fuzz"])
            .arguments(arguments)
            .arguments(&["--sanitizer=none", "--fuzz-dir", FOLDER, "--target-dir"])
            .argument(folder.join("build"))
    };
    steps.push(fuzz(&["build"]));
    for name in targets(&context.project().path(FOLDER))? {
        // What is found new is kept from run to run, apart from what is committed.
        let new = folder.join("corpus").join(&name);
        fs::create_dir_all(&new).with_context(|| format!("making {}", new.display()))?;
        let mut step = fuzz(&["run", &name])
            .argument(new)
            .argument(format!("{FOLDER}/corpus/{name}"))
            .argument("--")
            .argument(format!("-max_total_time={TIME_S}"))
            .argument(format!("-runs={INPUTS}"))
            .argument(format!("-timeout={INPUT_S}"));
        let words = format!("{FOLDER}/dictionaries/{name}.dict");
        if context.project().path(&words).exists() {
            step = step.argument(format!("-dict={words}"));
        }
        steps.push(step.counting(Runner::Fuzz).beside_others());
    }
    Ok(steps)
}

/// The names of all targets.
fn targets(folder: &Path) -> Result<Vec<String>> {
    let folder = folder.join("fuzz_targets");
    let entries = fs::read_dir(&folder).with_context(|| format!("reading {}", folder.display()))?;
    let mut names = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if let Some(stem) = path.file_stem() {
            names.push(stem.to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names)
}
