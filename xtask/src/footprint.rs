//! `cargo footprint`: flash, RAM, stack and instructions of the library on Arm's Cortex-M.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

use anyhow::Result;

use crate::BAD_INPUT;
use crate::arm::Tools;
use crate::project::{Project, run_on_stderr};

const HELP: &str = "\
usage: cargo footprint [--quick]

Builds the library with a program around it for Cortex-M3, M4F, M7 and M33, with and without vision, with
weights as trained and rounded to eight bits, runs it under QEMU, compares what it computes with this
machine, bit by bit, and writes flash, RAM, stack and instructions into docs/controller.

  --quick    Cortex-M4F and M7 with vision only; compare the figures with the written ones instead";

/// Each image of a target runs on one or two cores.
const TARGETS: [&str; 3] = [
    "thumbv7em-none-eabihf",
    "thumbv7m-none-eabi",
    "thumbv8m.main-none-eabihf",
];

/// Builds, runs and measures.
pub(crate) fn run(words: &[OsString]) -> Result<ExitCode> {
    let quick = match words {
        [] => false,
        [word] if word == "--quick" => true,
        [word] if word == "--help" || word == "-h" => {
            println!("{HELP}");
            return Ok(ExitCode::SUCCESS);
        }
        _ => {
            eprintln!("error: unknown arguments: see cargo footprint --help");
            return Ok(ExitCode::from(BAD_INPUT));
        }
    };
    let project = Project::find()?;
    let mut measure = measuring(&project, quick)?;
    Ok(if measure.status()?.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// The command that measures the images, which are built here.
fn measuring(project: &Project, quick: bool) -> Result<Command> {
    let mut build = Command::new("cargo");
    build.args([
        "build",
        "--quiet",
        "--locked",
        "--release",
        "--package=nsrm",
        "--package=nsrm-bench",
    ]);
    run_on_stderr(build.current_dir(project.root()))?;
    let tools = Tools::new(project);
    let mut measure = Command::new(project.target().join("release/footprint"));
    measure.current_dir(project.root());
    let (qemu, environment) = tools.qemu()?;
    measure
        .arg(qemu)
        .arg(tools.objdump()?)
        .arg(if quick { "compare" } else { "write" });
    for (name, value) in environment {
        measure.env(name, value);
    }
    for target in TARGETS {
        for features in [
            &["vision", "f32"][..],
            &["f32"],
            &["vision", "int8"],
            &["int8"],
        ] {
            if !quick || (target == TARGETS[0] && features.contains(&"vision")) {
                eprintln!(
                    "footprint: building for {target} {} ...",
                    features.join(", ")
                );
                measure.arg(tools.firmware(target, features)?);
            }
        }
    }
    Ok(measure)
}
