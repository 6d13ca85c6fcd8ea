//! The project's commands, as aliases of cargo (`.cargo/config.toml`):
//!
//! * `cargo demo [ARGUMENTS]`: a sentence and a scene in; program, sub-goals and
//!   pictures out.
//! * `cargo harness COMMAND [ARGUMENTS]`: any command of the Python package in
//!   `sim-harness`, in the project's own environment.
//! * `cargo robot [SENTENCE]`: all processes of a robot in a simulated world.
//! * `cargo chaos [--kills N]`, `cargo soak [--hours H]`, `cargo latency`: a robot's
//!   processes killed at random, at work for long, and measured.
//! * `cargo verify [--quick] [--only NAME]… [--list] [--install]`: every check.
//!
//! What they need of Python is installed into `.venv` in the checkout when it is
//! needed first, and again when its requirements or sources have changed.

mod environment;
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
       cargo harness COMMAND [ARGUMENTS]                       (cargo harness --help for all)
       cargo verify [--quick] [--only NAME]... [--list] [--install]";

/// What exits with 2 in all our commands: input that can't be used.
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

/// A command of the harness that is told where our programs, as they are now, are; each
/// is that of the package of its name.
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

/// Becomes `python -m nsrm_harness.cli ARGUMENTS`, so that signals and the exit
/// code are the harness's own. Returns only when it can't be started.
fn harness(arguments: Vec<OsString>) -> Result<ExitCode> {
    let environment = Environment::open(Project::find()?)?;
    environment.ensure(Requirements::of_command(&arguments))?;
    environment.ensure_module()?;
    let mut python = Command::new(environment.python());
    python.args(["-m", "nsrm_harness.cli"]).args(arguments);
    let error = python.exec();
    Err(anyhow::Error::new(error).context(format!(
        "{} could not be started; remove the folder .venv and try again",
        environment.python().display()
    )))
}
