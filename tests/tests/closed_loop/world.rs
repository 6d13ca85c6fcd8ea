//! A simulated camera, robot and clock.

use std::collections::VecDeque;

use nsrm_core::{Model, RawScene, Scene};
use nsrm_ipc::executive::{Command, Event, Executive, Failure, Limits, Mode, Sentence};
use nsrm_ipc::message::{Feedback, Outcome, SceneMessage};
use nsrm_tests::by_hand::raw_scene;
use nsrm_tests::world::BLOCKS;

pub(crate) const MS: u64 = 1_000_000;

/// What the controller says of every command, whatever its outcome.
pub(crate) const IN_THE_WAY: [u32; 2] = [3, 0];

/// What happens when both steps of a sentence are done at the first try.
pub(crate) const TWO_STEPS_DONE: [&str; 6] = [
    "planned from 0",
    "command 0",
    "reached 0",
    "planned from 1",
    "command 1",
    "reached 1",
];

/// What a sentence fails with then.
pub(crate) const fn unsuccessful(step: u8, outcome: Outcome) -> Failure {
    Failure::Unsuccessful {
        step,
        outcome,
        objects: IN_THE_WAY,
    }
}

/// What stands around an executive.
pub(crate) struct World<'m> {
    pub(crate) executive: Executive<'m>,
    pub(crate) scene: RawScene,
    /// What the camera shows of the scene.
    pub(crate) view: fn(&RawScene) -> RawScene,
    pub(crate) now_ns: u64,
    /// By how much the controller's clock is ahead.
    pub(crate) ahead_ns: u64,
    pub(crate) sequence: u64,
    /// The outcomes of the next commands; when none is left, `Reached`.
    pub(crate) outcomes: VecDeque<Outcome>,
    /// What happened, in order.
    pub(crate) log: Vec<String>,
    pub(crate) commands: Vec<Command>,
}

impl<'m> World<'m> {
    pub(crate) fn new(model: &'m Model<'m>, limits: Limits) -> Self {
        Self {
            executive: Executive::new(model, limits, 100),
            scene: raw_scene(model, &BLOCKS),
            view: |scene| *scene,
            now_ns: 10_000 * MS,
            ahead_ns: 0,
            sequence: 0,
            outcomes: VecDeque::new(),
            log: Vec::new(),
            commands: Vec::new(),
        }
    }

    pub(crate) fn ask(&mut self, sentence: &str, mode: Mode) -> u64 {
        let sentence = Sentence::try_from(sentence).unwrap();
        self.executive.ask(sentence, mode).unwrap()
    }

    pub(crate) fn message(&self, taken_ns: u64) -> SceneMessage {
        let mut raw = (self.view)(&self.scene);
        raw.header.sequence = self.sequence;
        raw.header.timestamp_ns = taken_ns;
        SceneMessage::from(&Scene::new(raw, self.executive.model()).unwrap())
    }

    pub(crate) fn see(&mut self) {
        self.sequence += 1;
        let message = self.message(self.now_ns);
        self.executive.on_scene(&message, self.now_ns).unwrap();
    }

    pub(crate) fn say(&mut self, command: &Command, outcome: Outcome) {
        let feedback = Feedback {
            plan: command.id.plan,
            sequence: 0,
            timestamp_ns: self.now_ns + self.ahead_ns,
            command: command.id.command,
            outcome: outcome as u32,
            objects: IN_THE_WAY,
        };
        self.executive.on_feedback(&feedback, self.now_ns).unwrap();
    }

    /// Moves the object to its sub-goal, as the robot would.
    pub(crate) fn carry_out(&mut self, command: &Command) {
        let id = command.planned.sub_goal.object;
        let objects = self.scene.objects.iter_mut();
        for object in objects.filter(|object| object.id == id) {
            object.location = command.planned.location;
        }
    }

    /// Polls, with a scene every 10 ms, until the sentence has ended.
    pub(crate) fn run(&mut self) -> Result<(), Failure> {
        self.run_with(|_, _| {})
    }

    /// As [`World::run`], and calls `then` right after each command was executed.
    pub(crate) fn run_with(
        &mut self,
        mut then: impl FnMut(&mut Self, &Command),
    ) -> Result<(), Failure> {
        for tick in 0..100_000 {
            self.now_ns += MS;
            if tick % 10 == 0 {
                self.see();
            }
            match self.executive.poll(self.now_ns) {
                Event::Waiting | Event::Working => {}
                Event::Planned(plan) => self.log.push(format!("planned from {}", plan.first())),
                Event::Command(command) => {
                    self.log.push(format!("command {}", command.step));
                    self.commands.push(command);
                    self.say(&command, Outcome::Accepted);
                    self.now_ns += 5000 * MS;
                    let outcome = self.outcomes.pop_front().unwrap_or(Outcome::Reached);
                    if outcome == Outcome::Reached {
                        self.carry_out(&command);
                        then(self, &command);
                    }
                    self.say(&command, outcome);
                }
                Event::Stop(id) => self.log.push(format!("stop {}", id.command)),
                Event::Clearing { step, .. } => self.log.push(format!("clearing {step}")),
                Event::Reached { step, .. } => self.log.push(format!("reached {step}")),
                Event::Again { step, why } => {
                    self.log.push(format!("again {step}: {}", why.kind()));
                }
                Event::Ended(result) => {
                    assert_eq!(self.executive.plan(), None);
                    assert_eq!(self.executive.poll(self.now_ns), Event::Waiting);
                    return result;
                }
            }
        }
        panic!("no end: {:?}", self.log);
    }

    /// Polls, with scenes, until a command is sent; does not execute it.
    pub(crate) fn until_command(&mut self) -> Command {
        loop {
            self.now_ns += MS;
            self.see();
            if let Event::Command(command) = self.executive.poll(self.now_ns) {
                return command;
            }
        }
    }

    /// Polls, with scenes, until a stop is sent; returns the number of its command.
    pub(crate) fn until_stop(&mut self) -> u32 {
        loop {
            self.now_ns += MS;
            self.see();
            match self.executive.poll(self.now_ns) {
                Event::Waiting | Event::Working => {}
                Event::Stop(id) => return id.command,
                event => panic!("{event:?}"),
            }
        }
    }
}
