//! The project's commands, as aliases of cargo (`.cargo/config.toml`):
//!
//! * `cargo demo [ARGUMENTS]`: plans a sentence in a simulated scene, executes it and
//!   writes images.
//! * `cargo harness COMMAND [ARGUMENTS]`: any command of the Python package in
//!   `sim-harness`, in the project's own environment.
//! * `cargo robot [SENTENCE]`: runs all processes of a robot in a simulated world.
//! * `cargo chaos [--kills N]`, `cargo soak [--hours H]`, `cargo latency`: kill a
//!   robot's processes at random, run them for hours, measure their latency.
//! * `cargo compare [--quick] [--out FOLDER]`: times other runtimes on the same weights.
//! * `cargo footprint [--quick]`: flash, RAM, stack and instructions on Cortex-M.
//! * `cargo verify [--quick] [--only NAME]… [--list] [--install]`: every check.
//!
//! The Python packages that they need are installed into `.venv` in the checkout on first
//! use, and again when requirements or sources have changed.

mod arm;
mod compare;
mod environment;
mod footprint;
mod project;
mod stamp;
mod verify;

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

use anyhow::Result;
use environment::{Environment, Requirements};
use project::Project;

const USAGE: &str = "\
usage: cargo demo [SENTENCE] [--seed N] [--out DIR] [--no-arm] [--record FILE.rrd] [--json]   (cargo demo --help for all)
       cargo robot [SENTENCE] [--seed N] [--no-arm] [--open-loop] [--config FILE] [--json]
       cargo chaos [--kills N] [--seed N] | cargo soak [--hours H] | cargo latency
       cargo compare [--quick] [--out FOLDER]
       cargo footprint [--quick]
       cargo harness COMMAND [ARGUMENTS]                       (cargo harness --help for all)
       cargo verify [--quick] [--only NAME]... [--list] [--install]";

/// The exit code of all our commands for invalid input.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let command = arguments.next().unwrap_or_default();
    let arguments: Vec<OsString> = arguments.collect();
    let outcome = match command.to_str() {
        Some("demo") => harness(
            std::iter::once(OsString::from("demo"))
                .chain(arguments)
                .collect(),
        ),
        Some("harness") => harness(arguments),
        Some("robot") => with_programs("robot", &["nsrm"], arguments),
        Some(trial @ ("chaos" | "latency" | "soak")) => {
            with_programs(trial, &["nsrm", "nsrm-trials"], arguments)
        }
        Some("compare") => compare::run(&arguments),
        Some("footprint") => footprint::run(&arguments),
        Some("verify") => verify::run(&arguments),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    outcome.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

/// Builds our programs, and runs a command of the harness with their paths. A program is named
/// like its package.
fn with_programs(command: &str, programs: &[&str], arguments: Vec<OsString>) -> Result<ExitCode> {
    let project = Project::find()?;
    let mut build = Command::new("cargo");
    build.args(["build", "--quiet", "--locked", "--release"]);
    let mut words: Vec<OsString> = vec![command.into()];
    for program in programs {
        build.args(["--package", program]);
        words.push(format!("--{program}").into());
        let path = project.target().join("release").join(program);
        words.push(path.into_os_string());
    }
    build.current_dir(project.root());
    project::run_on_stderr(&mut build)?;
    words.extend(arguments);
    harness(words)
}

/// Replaces this process by `python -m nsrm_harness.cli ARGUMENTS`, so that signals and the exit
/// code are the harness's own. Returns only if it cannot be started.
fn harness(arguments: Vec<OsString>) -> Result<ExitCode> {
    let environment = Environment::open(Project::find()?)?;
    environment.ensure(Requirements::of_command(&arguments))?;
    environment.ensure_module()?;
    let mut python = Command::new(environment.python());
    python.args(["-m", "nsrm_harness.cli"]).args(arguments);
    let error = python.exec();
    Err(anyhow::Error::new(error).context(format!(
        "cannot start {}; remove the folder .venv and try again",
        environment.python().display()
    )))
}
