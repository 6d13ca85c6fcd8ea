//! Counts the instructions of each job with valgrind's callgrind, and compares them with
//! `instructions.csv`: a loop that became slower shows in the change that made it so, however noisy
//! the machine is.
//!
//! `--write` writes the counts instead. With the name of a job, does it once, for callgrind.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result};
use nsrm_bench::{Job, Table, callgrind};

/// How far a count may be from what is written, as a fraction.
const TOLERANCE: f64 = 0.02;

fn main() -> Result<ExitCode> {
    let argument = std::env::args().nth(1);
    match argument.as_deref() {
        None => compare(),
        Some("--write") => write(),
        Some(name) => {
            let job = Job::ALL.into_iter().find(|job| job.name() == name);
            Table::new().run(job.with_context(|| format!("unknown job {name:?}"))?);
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn budget() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("instructions.csv")
}

fn write() -> Result<ExitCode> {
    let mut text = String::from("job,instructions\n");
    for job in Job::ALL {
        text += &format!("{},{}\n", job.name(), count(job)?);
    }
    std::fs::write(budget(), &text)?;
    print!("{text}");
    Ok(ExitCode::SUCCESS)
}

fn compare() -> Result<ExitCode> {
    let text = std::fs::read_to_string(budget()).context("reading instructions.csv")?;
    let mut within = true;
    println!(
        "{:<20} {:>12} {:>12} {:>8}",
        "job", "counted", "written", "change"
    );
    for job in Job::ALL {
        let line = text.lines().find_map(|line| {
            let (name, number) = line.split_once(',')?;
            (name == job.name()).then_some(number)
        });
        let line = line.with_context(|| format!("instructions.csv has no {}", job.name()))?;
        let (written, counted): (f64, f64) = (line.parse()?, count(job)? as f64);
        let change = counted / written - 1.0;
        within &= change.abs() <= TOLERANCE;
        let (name, percent) = (job.name(), 100.0 * change);
        println!("{name:<20} {counted:>12} {written:>12} {percent:>+7.1}%");
    }
    if within {
        return Ok(ExitCode::SUCCESS);
    }
    eprintln!(
        "error: more or fewer instructions than written, by over {:.0} %. If that is meant, write \
         them: cargo run --release -p nsrm-bench --bin instructions -- --write",
        100.0 * TOLERANCE
    );
    Ok(ExitCode::FAILURE)
}

/// The instructions of one run of a job, without those of its preparation.
fn count(job: Job) -> Result<u64> {
    callgrind::count("nsrm_bench::Table::run", &[job.name()])
}
