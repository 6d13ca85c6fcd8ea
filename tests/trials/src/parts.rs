//! The processes of a trial that are not `nsrm`'s own: a camera, and a controller.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Result;
use nsrm_ipc::clock::{Clock, now_ns, set_clock};
use nsrm_ipc::executive::CommandId;
use nsrm_ipc::message::{Feedback, Order, Outcome, Role, State, SubGoal, SubGoalError};
use nsrm_ipc::node::{HEARTBEAT_NS, Heartbeats};
use nsrm_ipc::service::{Carried, Hosts, Receiver, Robot, RobotName, Sender, set_global_config};
use nsrm_tests::isolated_memory;
use serde_json::json;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::journal::Journal;
use crate::world::World;

/// Time between two frames.
const FRAME: Duration = Duration::from_millis(33);
/// The longest time between two polls.
const NAP: Duration = Duration::from_millis(5);
/// How long a move takes, in milliseconds.
const MOVE_MS: std::ops::Range<u64> = 20..200;

/// The robot that a process belongs to.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct RobotArgs {
    /// The robot's name.
    #[arg(long)]
    robot: RobotName,
    /// The shared-memory folder.
    #[arg(long)]
    root: String,
    /// The prefix of names in shared memory.
    #[arg(long)]
    prefix: String,
    /// The journal.
    #[arg(long)]
    journal: PathBuf,
    /// Whether the robot's other processes run on another host.
    #[arg(long)]
    several_hosts: bool,
}

impl RobotArgs {
    pub(crate) fn join(&self, role: Role) -> Result<Robot> {
        self.join_other(&self.robot, role)
    }

    /// Joins another robot in the same shared memory.
    pub(crate) fn join_other(&self, robot: &RobotName, role: Role) -> Result<Robot> {
        let config = isolated_memory::config(&self.root, &self.prefix);
        set_global_config(&config)?;
        let robot = Robot::join(robot.clone(), role, &config)?;
        if !self.several_hosts {
            return Ok(robot);
        }
        set_clock(Clock::Wall);
        Ok(robot.with_hosts(Hosts::Several))
    }

    pub(crate) fn journal(&self) -> &Path {
        &self.journal
    }
}

/// A flag that SIGINT and SIGTERM set.
pub(crate) fn stop_on_signals() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// Cleans up dead nodes now and then, as every node does.
#[derive(Debug, Default)]
struct Cleanups {
    next_ns: u64,
}

impl Cleanups {
    fn hold(&mut self, robot: &Robot) {
        if now_ns() >= self.next_ns {
            robot.cleanup_dead_nodes();
            self.next_ns = now_ns() + HEARTBEAT_NS;
        }
    }
}

/// Publishes an image of the world thirty times a second.
pub(crate) fn camera(robot: &RobotArgs) -> Result<()> {
    let stop = stop_on_signals()?;
    let (mut world, mut moves) = World::of(robot.journal())?;
    let robot = robot.join(Role::Camera)?;
    let frames = robot.frames_out(world.bytes())?;
    let mut heartbeats = Heartbeats::begin(&robot, Role::Camera, now_ns())?;
    let (mut cleanups, mut sequence) = (Cleanups::default(), 0);
    while !stop.load(Ordering::Relaxed) {
        cleanups.hold(&robot);
        let taken_ns = now_ns();
        world.follow(&mut moves)?;
        sequence += 1;
        let header = world.header(sequence, taken_ns);
        // Without a reader it is lost, as a camera's images are.
        let _ = frames.send(header, world.bytes(), |image| world.paint(image));
        let _ = heartbeats.beat(State::Idle, now_ns());
        let passed = Duration::from_nanos(now_ns() - taken_ns);
        std::thread::sleep(FRAME.saturating_sub(passed));
    }
    Ok(())
}

/// Executes each command once: after some time, the block is at its sub-goal.
pub(crate) fn controller(robot: &RobotArgs, seed: u64) -> Result<()> {
    let stop = stop_on_signals()?;
    let journal = Journal::open(robot.journal(), "controller")?;
    let robot = robot.join(Role::Controller)?;
    let wait_set = robot.wait_set([SubGoal::SERVICE])?;
    let mut controller = Controller {
        commands: robot.receiver()?,
        feedback: robot.sender()?,
        journal,
        world: World::new()?,
        rng: fastrand::Rng::with_seed(seed),
        moving: None,
        last: None,
        sequence: 0,
    };
    let mut heartbeats = Heartbeats::begin(&robot, Role::Controller, now_ns())?;
    let mut cleanups = Cleanups::default();
    while !stop.load(Ordering::Relaxed) {
        cleanups.hold(&robot);
        let state = if controller.moving.is_some() {
            State::Busy
        } else {
            State::Idle
        };
        let _ = heartbeats.beat(state, now_ns());
        let mut commands: Vec<_> = controller.commands.waiting().map(|it| *it).collect();
        // A stop that arrives before its move.
        commands.sort_by_key(|command| command.read(now_ns()) != Ok(Order::Stop));
        for command in commands {
            controller.obey(&command)?;
        }
        controller.move_on()?;
        let _ = wait_set.wait(NAP);
    }
    Ok(())
}

#[derive(Debug)]
struct Controller {
    commands: Receiver<SubGoal>,
    feedback: Sender<Feedback>,
    journal: Journal,
    /// To know the existing blocks.
    world: World,
    rng: fastrand::Rng,
    /// The current command, and until when it runs.
    moving: Option<(SubGoal, u64)>,
    /// The last command, and its outcome.
    last: Option<(CommandId, Outcome)>,
    sequence: u64,
}

impl Controller {
    fn obey(&mut self, command: &SubGoal) -> Result<()> {
        let id = command.id();
        if let Some((last, outcome)) = self.last {
            if last == id {
                // A repeated command, or a stop that is too late.
                return self.say(id, outcome);
            }
            if (id.plan, id.command) < (last.plan, last.command) {
                return self.say(id, Outcome::Impossible);
            }
        }
        let doing = self.moving.map(|(command, _)| command.id());
        match command.read(now_ns()) {
            Ok(Order::Stop) => {
                if doing == Some(id) {
                    self.moving = None;
                    self.note("stopped", command)?;
                }
                self.end(id, Outcome::Stopped)
            }
            Ok(Order::Move { object, .. }) => {
                if doing == Some(id) {
                    return self.say(id, Outcome::Accepted);
                }
                if doing.is_some() {
                    return self.say(id, Outcome::Busy);
                }
                if !self.world.put(object, command.location) {
                    return self.end(id, Outcome::Impossible);
                }
                self.note("accepted", command)?;
                self.say(id, Outcome::Accepted)?;
                let end_ns = now_ns() + self.rng.u64(MOVE_MS) * 1_000_000;
                self.moving = Some((*command, end_ns));
                Ok(())
            }
            Err(SubGoalError::TooLate { .. }) => {
                self.note("came too late", command)?;
                self.end(id, Outcome::TooLate)
            }
            Err(_) => Ok(()),
        }
    }

    /// Ends the move when it is due.
    fn move_on(&mut self) -> Result<()> {
        match self.moving {
            Some((command, end_ns)) if now_ns() >= end_ns => {
                self.moving = None;
                // From this line on, the block is there.
                self.note("moved", &command)?;
                self.end(command.id(), Outcome::Reached)
            }
            _ => Ok(()),
        }
    }

    fn note(&self, what: &str, command: &SubGoal) -> Result<()> {
        self.journal.write(
            what,
            json!({
                "plan": command.plan,
                "command": command.command,
                "step": command.step,
                "object": command.object_id,
                "location": command.location,
            }),
        )
    }

    fn end(&mut self, id: CommandId, outcome: Outcome) -> Result<()> {
        self.last = Some((id, outcome));
        self.say(id, outcome)
    }

    fn say(&mut self, id: CommandId, outcome: Outcome) -> Result<()> {
        self.sequence += 1;
        let feedback = Feedback {
            plan: id.plan,
            sequence: self.sequence,
            timestamp_ns: now_ns(),
            command: id.command,
            outcome: outcome as u32,
            objects: [0; 2],
        };
        self.feedback.send(&feedback)?;
        Ok(())
    }
}
