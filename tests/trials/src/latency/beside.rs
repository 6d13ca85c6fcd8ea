//! Runs the computation alone in a process on the other core: one that a pipe wakes or, if the
//! answering process spins, that process, by messages through shared memory.

use std::io::{Read, Write};
use std::process::{ChildStdin, ChildStdout};

use anyhow::{Context as _, Result, bail};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::CommandId;
use nsrm_ipc::message::{Feedback, Outcome, Role, SubGoal};
use nsrm_ipc::service::{Receiver, Robot, Sender};

use super::alone::Alone;
use super::answering::{Answering, Peer, WaitMode};
use super::{PATIENCE_NS, REST};

/// The robot for the baseline, besides the measured one.
pub(super) const BESIDE: &str = "beside";

/// The request: prepare, which is not measured, or compute.
const PREPARE: u8 = b'p';
const COMPUTE: u8 = b'c';

fn answer(word: u32, alone: &mut impl Alone) -> Result<u64> {
    if word == u32::from(COMPUTE) {
        return alone.take();
    }
    alone.prepare().map(|()| 0)
}

/// Answers each byte from stdin with the time of its work, until stdin ends.
pub(super) fn answer_bytes(alone: &mut impl Alone) -> Result<()> {
    let (mut input, mut output) = (std::io::stdin(), std::io::stdout());
    let mut byte = [0];
    while input.read(&mut byte)? == 1 {
        let taken_ns = answer(byte[0].into(), alone)?;
        output.write_all(&taken_ns.to_ne_bytes())?;
        output.flush()?;
    }
    Ok(())
}

/// The process that computes.
trait Asked {
    /// Returns the answer.
    fn ask(&mut self, byte: u8) -> Result<u64>;
    /// Ends its work.
    fn end(self: Box<Self>) -> Result<()>;
}

/// Another process, woken by a pipe.
pub(super) struct ByPipe {
    input: ChildStdin,
    output: ChildStdout,
    peer: Answering,
}

impl ByPipe {
    pub(super) fn start(peer: Peer, core: usize) -> Result<Self> {
        let mut peer = Answering::start(peer, WaitMode::Waiting, core)?;
        let (input, output) = peer.pipes().context("no pipe")?;
        Ok(Self {
            input,
            output,
            peer,
        })
    }

    /// Wakes it; returns the time until its answer arrives, nanoseconds.
    pub(super) fn way(&mut self) -> Result<u64> {
        let begun_ns = now_ns();
        self.ask(COMPUTE)?;
        Ok(now_ns() - begun_ns)
    }

    /// Ends its work.
    pub(super) fn end(mut self) -> Result<()> {
        drop(self.input);
        self.peer.wait()
    }
}

impl Asked for ByPipe {
    fn ask(&mut self, byte: u8) -> Result<u64> {
        self.input.write_all(&[byte])?;
        let mut taken_ns = [0; 8];
        self.output.read_exact(&mut taken_ns)?;
        Ok(u64::from_ne_bytes(taken_ns))
    }

    fn end(self: Box<Self>) -> Result<()> {
        (*self).end()
    }
}

/// A spinning process, by shared memory.
pub(super) struct ByMemory {
    words: Sender<SubGoal>,
    taken: Receiver<Feedback>,
    number: u64,
}

impl ByMemory {
    pub(super) fn new(robot: &Robot) -> Result<Self> {
        Ok(Self {
            words: robot.sender()?,
            taken: robot.receiver()?,
            number: 0,
        })
    }
}

impl Asked for ByMemory {
    fn ask(&mut self, byte: u8) -> Result<u64> {
        self.number += 1;
        let id = CommandId {
            plan: self.number,
            command: byte.into(),
        };
        let end_ns = now_ns() + PATIENCE_NS;
        // It may not have started yet.
        while self.words.send(&SubGoal::stop(id))? == 0 && now_ns() < end_ns {
            std::thread::sleep(REST);
        }
        while now_ns() < end_ns {
            let taken = self.taken.receive()?;
            if let Some(taken) = taken.filter(|taken| taken.plan == self.number) {
                return Ok(taken.timestamp_ns);
            }
        }
        bail!("no answer after {} s", PATIENCE_NS / 1_000_000_000)
    }

    fn end(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

/// Answers requests through shared memory.
pub(super) struct Answers<A> {
    words: Receiver<SubGoal>,
    taken: Sender<Feedback>,
    alone: A,
}

impl<A: Alone> Answers<A> {
    pub(super) fn new(robot: &Robot, alone: A) -> Result<Self> {
        Ok(Self {
            words: robot.receiver()?,
            taken: robot.sender()?,
            alone,
        })
    }

    /// Computes if requested.
    pub(super) fn poll(&mut self) -> Result<()> {
        let Some(word) = self.words.receive()? else {
            return Ok(());
        };
        let id = word.id();
        let taken_ns = answer(id.command, &mut self.alone)?;
        self.taken.send(&Feedback {
            plan: id.plan,
            sequence: id.plan,
            timestamp_ns: taken_ns,
            command: id.command,
            outcome: Outcome::Accepted as u32,
            objects: [0; 2],
        })?;
        Ok(())
    }
}

/// The process that does the computation alone.
pub(super) struct Beside {
    robot: Robot,
    asked: Box<dyn Asked>,
}

impl Beside {
    /// * `computing`: the process to wake, if the answering process waits
    /// * `peer`: the answering process, which computes if it spins
    pub(super) fn start(
        wait: WaitMode,
        computing: Peer,
        peer: &Answering,
        core: usize,
    ) -> Result<Self> {
        let join = |at: &Answering| at.join(BESIDE, Role::Camera);
        let (robot, asked): (_, Box<dyn Asked>) = match wait {
            WaitMode::Waiting => {
                let asked = ByPipe::start(computing, core)?;
                (join(&asked.peer)?, Box::new(asked))
            }
            WaitMode::Spinning => {
                let robot = join(peer)?;
                let asked = ByMemory::new(&robot)?;
                (robot, Box::new(asked))
            }
        };
        Ok(Self { robot, asked })
    }

    /// A robot whose frames it receives.
    pub(super) const fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Lets it prepare a computation.
    pub(super) fn prepare(&mut self) -> Result<()> {
        self.asked.ask(PREPARE).map(|_| ())
    }

    /// Lets it compute; returns the time there, nanoseconds.
    pub(super) fn take(&mut self) -> Result<u64> {
        self.asked.ask(COMPUTE)
    }

    /// Ends its work.
    pub(super) fn end(self) -> Result<()> {
        self.asked.end()
    }
}
