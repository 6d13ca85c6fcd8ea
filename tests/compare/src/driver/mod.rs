//! Starts, checks and times the contenders, and writes the report.

mod child;
mod machine;
mod report;
mod rounds;
mod table;
mod times;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, ensure};
use clap::Args;
use nsrm_compare::{Inputs, Job, Table as Scene};

use child::{Child, KINDS, Programs};
use report::Report;
use rounds::Rounds;
use table::Table;

/// What to time, and where everything is.
#[derive(Debug, Args)]
pub(crate) struct Settings {
    /// Folder with the inputs, the graphs and the model file.
    #[arg(long)]
    folder: PathBuf,
    /// Folder with the contenders' programs.
    #[arg(long)]
    programs: PathBuf,
    /// Python with the harness and the packages of `compare.txt`.
    #[arg(long)]
    python: PathBuf,
    /// ONNX Runtime's shared library.
    #[arg(long)]
    library: PathBuf,
    /// Time fewer blocks.
    #[arg(long)]
    quick: bool,
    /// Folder for `compare.csv`, `compare.png` and `README.md`; without it nothing is written.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Time these contenders only, and `nsrm`.
    #[arg(long, value_delimiter = ',', value_parser = KINDS.map(|kind| kind.name))]
    only: Vec<String>,
}

/// The contender with which all must agree.
const OURS: &str = "nsrm";
/// The one of the last line.
const RIVAL: &str = "onnxruntime";

/// Writes the inputs of all jobs.
pub(crate) fn write_inputs(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    Inputs::new(&Scene::new()?)?.write(&folder.join("inputs.safetensors"))
}

/// Times all contenders; the result is the last line on standard output.
pub(crate) fn measure(settings: &Settings) -> Result<()> {
    let core = machine::pin_to_one_core()?;
    let inputs = Inputs::read(&settings.folder.join("inputs.safetensors"))?;
    let programs = Programs {
        folder: &settings.folder,
        programs: &settings.programs,
        python: &settings.python,
        library: &settings.library,
    };
    let mut children = Vec::new();
    for kind in KINDS {
        let wanted = settings.only.iter().any(|name| name == kind.name) || kind.name == OURS;
        if settings.only.is_empty() || wanted {
            eprintln!("starting {} on core {core}", kind.name);
            children.push(Child::start(kind, &programs)?);
        }
    }
    let missing = check(&mut children, &inputs)?;
    let rounds = if settings.quick {
        Rounds::QUICK
    } else {
        Rounds::FULL
    };
    let measured = rounds.run(&mut children, &missing)?;
    let report = Report {
        table: Table {
            contenders: children.iter().map(Child::name).collect(),
            measured,
            missing,
        },
        versions: children.iter().map(Child::version).collect(),
        rounds,
    };
    println!("{}", report.table.markdown());
    if let Some(out) = &settings.out {
        fs::create_dir_all(out).with_context(|| format!("making {}", out.display()))?;
        report.write(out)?;
        draw(&settings.python, out)?;
    }
    if let Some(line) = report.table.against(RIVAL, OURS) {
        println!("{line}");
    }
    Ok(())
}

/// A job that a contender cannot express, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Missing {
    contender: &'static str,
    job: Job,
    reason: String,
}

/// Compares what each contender computes with ours; gives what they cannot express.
fn check(children: &mut [Child], inputs: &Inputs) -> Result<Vec<Missing>> {
    let mut missing = Vec::new();
    for job in Job::ALL {
        let ours = children.iter_mut().find(|child| child.name() == OURS);
        let ours = ours.context("nsrm does not take part")?.outputs(job)?;
        let ours = ours.map_err(|reason| anyhow::anyhow!("{OURS} cannot do {job}: {reason}"))?;
        for child in children.iter_mut().filter(|child| child.computes()) {
            match child.outputs(job)? {
                Ok(outputs) => outputs.check(&ours, job, inputs).with_context(|| {
                    format!(
                        "{} computes {job} differently; nothing was timed",
                        child.name()
                    )
                })?,
                Err(reason) => missing.push(Missing {
                    contender: child.name(),
                    job,
                    reason,
                }),
            }
        }
    }
    eprintln!("all contenders agree with {OURS}");
    Ok(missing)
}

/// Plots the table in `out`.
fn draw(python: &Path, out: &Path) -> Result<()> {
    let status = Command::new(python)
        .args(["-m", "nsrm_harness.cli", "comparison"])
        .arg(out.join("compare.csv"))
        .arg("--out")
        .arg(out.join("compare.png"))
        .stdin(Stdio::null())
        .stdout(std::io::stderr())
        .status()
        .with_context(|| format!("cannot start {}", python.display()))?;
    ensure!(
        status.success(),
        "the plot was not drawn; the message is above"
    );
    Ok(())
}
