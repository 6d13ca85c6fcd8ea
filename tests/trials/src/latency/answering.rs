//! The answering process of a measurement: a planner, perception, a receiver that acknowledges
//! frames, or the same computation woken by a byte in a pipe.

use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};
use clap::ValueEnum;
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::Limits;
use nsrm_ipc::message::{Feedback, Outcome, Role};
use nsrm_ipc::node::{PerceptionNode, PlannerNode};
use nsrm_ipc::service::{CAMERA, Robot};
use nsrm_tabletop::TABLETOP;
use nsrm_tests::isolated_memory::IsolatedMemory;
use rustix::process::{Pid, Signal, kill_process};
use rustix::thread::{CpuSet, sched_setaffinity};

use super::alone::{FrameAlone, Nothing, SentenceAlone};
use super::beside::{Answers, BESIDE, answer_bytes};
use crate::parts::{RobotArgs, stop_on_signals};
use crate::process_group::ROBOT;

/// The kinds of answering processes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Peer {
    /// Woken by a pipe, does nothing.
    Pipe,
    /// The planner's computation, woken by a pipe.
    SentenceByPipe,
    /// Perception's computation, woken by a pipe, on a frame of shared memory.
    FrameByPipe,
    /// The planner.
    Planner,
    /// Perception.
    Perception,
    /// A receiver that acknowledges frames.
    Frames,
}

/// How a process receives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum WaitMode {
    /// By spinning.
    Spinning,
    /// When it is woken up.
    Waiting,
}

impl WaitMode {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Spinning => "spinning",
            Self::Waiting => "waiting",
        }
    }
}

/// Answers until it is stopped, in a process of its own.
pub(crate) fn answer(robot: &RobotArgs, peer: Peer, wait: WaitMode, core: usize) -> Result<()> {
    let stop = stop_on_signals()?;
    stay_on(core)?;
    let is_spinning = wait == WaitMode::Spinning;
    let beside = |role| robot.join_other(&BESIDE.parse()?, role);
    match peer {
        Peer::Pipe => answer_bytes(&mut Nothing)?,
        Peer::SentenceByPipe => answer_bytes(&mut SentenceAlone::new()?)?,
        Peer::FrameByPipe => answer_bytes(&mut FrameAlone::new(&beside(Role::Perception)?)?)?,
        Peer::Planner => {
            let robot = robot.join(Role::Planner)?;
            let mut node = PlannerNode::begin(robot, &TABLETOP, Limits::default())?;
            if !is_spinning {
                return Ok(node.run(&stop)?);
            }
            let mut beside = Answers::new(&beside(Role::Planner)?, SentenceAlone::new()?)?;
            while !stop.load(Ordering::Relaxed) {
                node.work(now_ns());
                beside.poll()?;
            }
        }
        Peer::Perception => {
            let robot = robot.join(Role::Perception)?;
            let mut node = PerceptionNode::begin(robot, &TABLETOP)?;
            if !is_spinning {
                return Ok(node.run(&stop)?);
            }
            let robot = beside(Role::Perception)?;
            let mut beside = Answers::new(&robot, FrameAlone::new(&robot)?)?;
            while !stop.load(Ordering::Relaxed) {
                node.poll(now_ns());
                beside.poll()?;
            }
        }
        Peer::Frames => take_frames(robot, wait, &stop)?,
    }
    Ok(())
}

/// Receives frames in place and acknowledges them.
fn take_frames(robot: &RobotArgs, wait: WaitMode, stop: &AtomicBool) -> Result<()> {
    let robot = robot.join(Role::Controller)?;
    let frames = robot.frames_in()?;
    let wait_set = robot.wait_set([CAMERA])?;
    let said = robot.sender::<Feedback>()?;
    while !stop.load(Ordering::Relaxed) {
        if let Some(frame) = frames.receive()? {
            let number = frame.user_header().sequence;
            said.send(&feedback(1, 1, number, Outcome::Accepted))?;
        } else if wait == WaitMode::Waiting {
            let _ = wait_set.wait(Duration::from_millis(100));
        }
    }
    Ok(())
}

pub(super) fn feedback(plan: u64, command: u32, sequence: u64, outcome: Outcome) -> Feedback {
    Feedback {
        plan,
        sequence,
        timestamp_ns: now_ns(),
        command,
        outcome: outcome as u32,
        objects: [0; 2],
    }
}

/// An answering process, stopped when this is dropped.
pub(super) struct Answering {
    child: Child,
    memory: IsolatedMemory,
}

impl Answering {
    pub(super) fn start(peer: Peer, wait: WaitMode, core: usize) -> Result<Self> {
        let memory = IsolatedMemory::new(&format!("latency-{}", wait.word()));
        let name = |value: &dyn ValueEnumName| value.name();
        let child = Command::new(std::env::current_exe()?)
            .args(["answer", "--robot", ROBOT, "--journal", "none", "--root"])
            .arg(memory.root())
            .args(["--prefix", memory.prefix()])
            .args(["--peer", &name(&peer), "--wait", &name(&wait)])
            .args(["--core", &core.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        Ok(Self { child, memory })
    }

    /// Joins a robot in its shared memory.
    pub(super) fn join(&self, robot: &str, role: Role) -> Result<Robot> {
        Ok(Robot::join(robot.parse()?, role, &self.memory.config)?)
    }

    /// Its stdin and stdout; only the first call returns them.
    pub(super) fn pipes(&mut self) -> Option<(ChildStdin, ChildStdout)> {
        self.child.stdin.take().zip(self.child.stdout.take())
    }

    /// Stops it; its shared memory remains.
    pub(super) fn end(&mut self) -> Result<()> {
        kill_process(Pid::from_child(&self.child), Signal::TERM)?;
        self.wait()
    }

    /// Waits until it has ended on its own.
    pub(super) fn wait(&mut self) -> Result<()> {
        let status = self.child.wait()?;
        ensure!(status.success(), "the answering process ended: {status}");
        Ok(())
    }
}

impl Drop for Answering {
    /// If a measurement is aborted, no process keeps running and no file is left.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.memory.clear();
    }
}

/// Pins this process to one core, so that the two run on different ones: nothing affects the time
/// of waking more.
pub(super) fn stay_on(core: usize) -> Result<()> {
    let mut cores = CpuSet::new();
    cores.set(core);
    sched_setaffinity(None, &cores).with_context(|| format!("pinning to core {core}"))
}

/// The name of a value on the command line.
trait ValueEnumName {
    fn name(&self) -> String;
}

impl<T: ValueEnum> ValueEnumName for T {
    fn name(&self) -> String {
        let value = self.to_possible_value();
        value
            .map(|value| value.get_name().into())
            .unwrap_or_default()
    }
}
