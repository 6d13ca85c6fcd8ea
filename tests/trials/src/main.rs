//! A robot's processes under load: `nsrm-trials chaos | soak | latency`. What they
//! measure and write down is judged and drawn by the harness: `cargo chaos`,
//! `cargo soak`, `cargo latency`.

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

use parts::Place;

/// A robot's processes under load.
#[derive(Parser)]
#[command(name = "nsrm-trials", version)]
enum Trial {
    /// Kill processes at random moments and write down what happens.
    Chaos(chaos::Options),
    /// Let processes work for hours and write down what they hold.
    Soak(soak::Options),
    /// Measure how fast processes answer.
    Latency(latency::Options),
    /// Be who answers.
    #[command(hide = true)]
    Answer {
        #[command(flatten)]
        place: Place,
        #[arg(long)]
        peer: latency::Peer,
        #[arg(long)]
        looks: latency::Looks,
        /// The core that it stays on.
        #[arg(long)]
        core: usize,
    },
    /// Be the camera of a trial.
    #[command(hide = true)]
    Camera(Place),
    /// Be the controller of a trial.
    #[command(hide = true)]
    Controller {
        #[command(flatten)]
        place: Place,
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
            place,
            peer,
            looks,
            core,
        } => latency::answer(place, *peer, *looks, *core),
        Trial::Camera(place) => parts::camera(place),
        Trial::Controller { place, seed } => parts::controller(place, *seed),
    }
}
