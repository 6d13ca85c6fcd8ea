//! The subcommands that run as processes of a robot.

mod config;
mod say;
mod watch;

use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Subcommand;
use iceoryx2::prelude::{LogLevel, set_log_level};
use nsrm::AnyModel;
use nsrm_core::nn::Precision;
use nsrm_ipc::executive::Mode;
use nsrm_ipc::message::Role;
use nsrm_ipc::node::{PerceptionNode, PlannerNode};
use nsrm_ipc::service::Robot;
use signal_hook::consts::{SIGINT, SIGTERM};
use tracing::info;

use crate::Failure;
use config::Config;

#[derive(Subcommand)]
pub(crate) enum RobotCommand {
    /// Run a robot's planner: takes sentences, sends sub-goals, observes the scene after each step.
    Serve {
        #[command(flatten)]
        options: RobotOptions,
    },
    /// Run a robot's perception: turns camera frames into scenes.
    Perceive {
        #[command(flatten)]
        options: RobotOptions,
    },
    /// Show a robot's live nodes, the messages between them and the planner's last replies.
    Watch {
        /// Print JSON: a line every half second and whenever a node is lost.
        #[arg(long)]
        json: bool,
        /// Print once and exit.
        #[arg(long)]
        once: bool,
        #[command(flatten)]
        options: RobotOptions,
    },
    /// Send a sentence to a robot and follow its execution. Ctrl-C stops the robot.
    Say {
        /// The sentence, as one argument.
        sentence: String,
        /// Print the plan and move nothing.
        #[arg(long, conflicts_with = "open_loop")]
        plan_only: bool,
        /// Execute the first plan without observing the scene after each step, as in the paper.
        #[arg(long)]
        open_loop: bool,
        /// Ask back after a refusal and read the answer from the input, also if that is no terminal.
        #[arg(long)]
        dialogue: bool,
        /// Print JSON, one line per event, and do not ask back.
        #[arg(long, conflicts_with = "dialogue")]
        json: bool,
        #[command(flatten)]
        options: RobotOptions,
    },
}

#[derive(clap::Args)]
pub(crate) struct RobotOptions {
    /// Name of the robot on this machine.
    #[arg(long, value_name = "NAME")]
    robot: Option<String>,
    /// Configuration file (TOML); options on the command line override it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// The model file (safetensors); the built-in model by default.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
}

impl RobotOptions {
    fn read(&self) -> Result<Config, Failure> {
        Ok(Config::read(
            self.config.as_ref(),
            self.robot.as_deref(),
            self.model.as_ref(),
        )?)
    }
}

impl RobotCommand {
    pub(crate) const fn wants_json(&self) -> bool {
        matches!(self, Self::Say { json: true, .. })
    }

    pub(crate) fn run(&self) -> Result<(), Failure> {
        // Its other messages duplicate our errors.
        set_log_level(LogLevel::Fatal);
        match self {
            Self::Serve { options } => serve(&options.read()?),
            Self::Perceive { options } => perceive(&options.read()?),
            Self::Watch {
                json,
                once,
                options,
            } => watch::watch(&options.read()?, *json, *once),
            Self::Say {
                sentence,
                plan_only,
                open_loop,
                dialogue,
                json,
                options,
            } => {
                let mode = match (plan_only, open_loop) {
                    (true, _) => Mode::PlanOnly,
                    (_, true) => Mode::OpenLoop,
                    _ => Mode::ClosedLoop,
                };
                let asks = *dialogue || (!json && std::io::stdin().is_terminal());
                say::say(&options.read()?, sentence, mode, *json, asks)
            }
        }
    }
}

/// A flag that SIGINT and SIGTERM set.
fn stop_on_signals() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

fn join(config: &Config, role: Role) -> Result<Robot, Failure> {
    let robot = Robot::join(config.robot.clone(), role, &config.shared_memory)?;
    Ok(robot.with_hosts(config.hosts))
}

/// Logs to stderr, filtered by `NSRM_LOG` (a level, or a filter of `tracing`).
fn log() {
    let filter = tracing_subscriber::EnvFilter::try_from_env("NSRM_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("info"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .with_writer(std::io::stderr)
        .init();
}

fn open(config: &Config) -> Result<AnyModel, Failure> {
    crate::open(config.model.as_ref(), Precision::F32)
}

fn serve(config: &Config) -> Result<(), Failure> {
    log();
    let any = open(config)?;
    let model = any.model();
    let stop = stop_on_signals()?;
    let robot = join(config, Role::Planner)?;
    let mut node = PlannerNode::begin(robot, &model, config.limits)?;
    info!(robot = %config.robot, domain = model.header.domain, "planning");
    node.run(&stop)?;
    info!("stopped");
    Ok(())
}

fn perceive(config: &Config) -> Result<(), Failure> {
    log();
    let any = open(config)?;
    let model = any.model();
    let stop = stop_on_signals()?;
    let robot = join(config, Role::Perception)?;
    let mut node = PerceptionNode::begin(robot, &model)?;
    info!(robot = %config.robot, domain = model.header.domain, "perceiving");
    node.run(&stop)?;
    info!("stopped");
    Ok(())
}
