//! A robot's processes under load: `nsrm-trials chaos | soak | latency`. The harness judges and
//! plots their records: `cargo chaos`, `cargo soak`, `cargo latency`.

mod chaos;
mod client;
mod journal;
mod latency;
mod parts;
mod process_group;
mod soak;
mod world;

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use iceoryx2::prelude::{LogLevel, set_log_level};

use parts::RobotArgs;

/// Run a robot's processes under load.
#[derive(Parser)]
#[command(name = "nsrm-trials", version)]
enum Trial {
    /// Kill processes at random times and record what happens.
    Chaos(chaos::Options),
    /// Run processes for hours and record their resources.
    Soak(soak::Options),
    /// Measure the latency of processes.
    Latency(latency::Options),
    /// Run an answering process.
    #[command(hide = true)]
    Answer {
        #[command(flatten)]
        robot: RobotArgs,
        #[arg(long)]
        peer: latency::Peer,
        #[arg(long)]
        wait: latency::WaitMode,
        /// The core to run on.
        #[arg(long)]
        core: usize,
    },
    /// Run the camera of a trial.
    #[command(hide = true)]
    Camera(RobotArgs),
    /// Run the controller of a trial.
    #[command(hide = true)]
    Controller {
        #[command(flatten)]
        robot: RobotArgs,
        #[arg(long)]
        seed: u64,
    },
}

fn main() -> ExitCode {
    set_log_level(LogLevel::Fatal);
    match run(&Trial::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("nsrm-trials: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(trial: &Trial) -> Result<()> {
    match trial {
        Trial::Chaos(options) => chaos::run(options),
        Trial::Soak(options) => soak::run(options),
        Trial::Latency(options) => latency::run(options),
        Trial::Answer {
            robot,
            peer,
            wait,
            core,
        } => latency::answer(robot, *peer, *wait, *core),
        Trial::Camera(robot) => parts::camera(robot),
        Trial::Controller { robot, seed } => parts::controller(robot, *seed),
    }
}
