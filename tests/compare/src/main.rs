//! The driver of `cargo compare`: starts all contenders on one core, checks that they agree with ours,
//! and times each job of each in turn, block by block, so that drift of the machine hits all alike.

#![forbid(unsafe_code)]

mod driver;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Times our inference and that of other runtimes on the same weights.
#[derive(Debug, Parser)]
#[command(name = "nsrm-compare")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write the inputs of all jobs to FOLDER/inputs.safetensors.
    Inputs {
        /// Folder that all contenders read.
        folder: PathBuf,
    },
    /// Time all contenders.
    Measure(driver::Settings),
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Inputs { folder } => driver::write_inputs(&folder),
        Command::Measure(settings) => driver::measure(&settings),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
