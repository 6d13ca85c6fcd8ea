//! The closed loop: parses a sentence, grounds the next step in the observed scene, commands it,
//! observes the result, and continues, retries or gives up with a reason.
//!
//! An [`Executive`] knows neither processes nor clocks: its caller passes in scenes, feedback and
//! the time, and [`Executive::poll`] returns what to do. Each call does a bounded amount of work
//! and never allocates.
//!
//! A sentence ends with [`Event::Ended`]. If its last command might still be accepted or executed,
//! [`Event::Stop`] comes first.

mod belief;
mod failure;
mod job;
mod limits;
mod meant;
mod placed;
mod scene_gate;
mod stage;
mod view;

pub use failure::{Failure, SceneFault};
pub use limits::{Limits, LimitsError};

use heapless::String;
use nsrm_core::planner::PlannedStep;
use nsrm_core::{MAX_OBJECTS, MAX_SENTENCE_BYTES, Model, Plan, Planner};
use thiserror::Error;

use crate::message::{Feedback, FeedbackError, SceneMessage};
use job::Job;
use scene_gate::{AHEAD_NS, SceneGate};

/// The text of a sentence.
pub type Sentence = String<MAX_SENTENCE_BYTES>;

/// How a sentence is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Plan only; nothing moves.
    PlanOnly,
    /// Ground each step in the scene observed after the previous step.
    ClosedLoop,
    /// Execute the initial plan without observing again, as in the paper.
    OpenLoop,
}

/// The identity of a command among all commands of a planner and its predecessors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CommandId {
    /// Number of the plan; plans of later planners have greater numbers.
    pub plan: u64,
    /// Number of the command within its plan, from 1; a retry is a new command.
    pub command: u32,
}

/// A command for the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// The command's identity.
    pub id: CommandId,
    /// The deadline for starting it, nanoseconds; then it is abandoned, and a stop follows.
    pub until_ns: u64,
    /// Which step of the program, from 0.
    pub step: u8,
    /// How many steps the program has.
    pub steps: u8,
    /// The object and its sub-goal.
    pub planned: PlannedStep,
    /// Ids of objects that must stay where they are, besides the reference: the objects and
    /// references of completed steps; 0 for none.
    pub keep: [u32; MAX_OBJECTS],
}

/// The result of [`Executive::poll`].
#[derive(Debug, Clone, PartialEq)]
#[must_use = "a command or a result would be lost"]
// The largest variant is passed on once per plan.
#[allow(clippy::large_enum_variant)]
pub enum Event {
    /// Nothing to do until something arrives or time passes.
    Waiting,
    /// Some work was done; more is left.
    Working,
    /// The sentence was parsed, and its steps grounded from the next one on.
    Planned(Plan),
    /// Send the controller this command.
    Command(Command),
    /// Send the controller a stop of this command.
    Stop(CommandId),
    /// Other objects are moved aside before a step's object is moved.
    Clearing {
        /// Which step, from 0.
        step: u8,
        /// Id of the step's object.
        object: u32,
        /// Ids of the objects that are moved aside; the step's own object if it is regrasped on the
        /// way; 0 for none.
        first: [u32; 2],
    },
    /// A step succeeded.
    Reached {
        /// Which step, from 0.
        step: u8,
        /// How far from its sub-goal the object was observed, metres; NaN if it was not observed.
        off_m: f32,
    },
    /// A step will be retried.
    Again {
        /// Which step, from 0.
        step: u8,
        /// What went wrong.
        why: Failure,
    },
    /// The sentence was executed, or why not.
    Ended(Result<(), Failure>),
}

/// Another sentence is being executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("another sentence (plan {plan}) is being executed: wait for it, or cancel it")]
pub struct Busy {
    /// Number of its plan.
    pub plan: u64,
}

/// Executes one sentence at a time.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../core/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_ipc::executive::{Event, Executive, Limits, Mode, Sentence};
/// use nsrm_ipc::message::{Feedback, Outcome, SceneMessage};
/// use nsrm_tabletop::TABLETOP;
///
/// let mut executive = Executive::new(&TABLETOP, Limits::default(), 1);
/// let sentence = Sentence::try_from("put the red block on the lego block").expect("it fits");
/// executive.ask(sentence, Mode::OpenLoop)?;
/// let mut now_ns = 1_000_000_000;
/// let mut message = SceneMessage::from(&scene(&TABLETOP));
/// message.timestamp_ns = now_ns;
/// executive.on_scene(&message, now_ns)?;
/// let result = loop {
///     now_ns += 1_000_000;
///     match executive.poll(now_ns) {
///         Event::Command(command) => {
///             // To the controller, which does it and says so.
///             let feedback = |sequence, outcome| Feedback {
///                 plan: command.id.plan,
///                 sequence,
///                 timestamp_ns: now_ns,
///                 command: command.id.command,
///                 outcome: outcome as u32,
///                 objects: [0; 2],
///             };
///             executive.on_feedback(&feedback(1, Outcome::Accepted), now_ns)?;
///             executive.on_feedback(&feedback(2, Outcome::Reached), now_ns)?;
///         }
///         Event::Ended(result) => break result,
///         Event::Waiting => panic!("it has all that it needs"),
///         other => println!("{other:?}"),
///     }
/// };
/// assert_eq!(result, Ok(()));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Executive<'m> {
    planner: Planner<'m>,
    limits: Limits,
    scene_gate: SceneGate,
    next_plan: u64,
    job: Option<Job<'m>>,
    /// The latest time that was passed in.
    latest_ns: u64,
}

impl<'m> Executive<'m> {
    /// An executive without a sentence.
    ///
    /// * `first_plan`: number of its first plan; must exceed the numbers of any earlier executive
    ///   of the same controller; the monotonic time in nanoseconds does
    pub fn new(model: &'m Model<'m>, limits: Limits, first_plan: u64) -> Self {
        Self {
            planner: Planner::new(model),
            limits,
            scene_gate: SceneGate::new(),
            next_plan: first_plan,
            job: None,
            latest_ns: 0,
        }
    }

    /// The model.
    pub const fn model(&self) -> &'m Model<'m> {
        self.planner.model()
    }

    /// Number of the plan that is being executed.
    pub fn plan(&self) -> Option<u64> {
        self.job.as_ref().map(|job| job.number)
    }

    /// Starts a sentence; returns the number of its plan.
    pub fn ask(&mut self, sentence: Sentence, mode: Mode) -> Result<u64, Busy> {
        if let Some(plan) = self.plan() {
            return Err(Busy { plan });
        }
        let plan = self.next_plan;
        self.next_plan = plan.wrapping_add(1);
        self.scene_gate.forget_camera();
        self.job = Some(Job::new(self.planner, plan, sentence, mode));
        Ok(plan)
    }

    /// Cancels the sentence: a running motion is stopped, and the sentence ends with
    /// [`Failure::Cancelled`].
    pub fn cancel(&mut self) {
        if let Some(job) = &mut self.job {
            job.cancel();
        }
    }

    /// Takes a scene that has arrived; an error says why it is rejected.
    ///
    /// Cost: the checks of [`SceneMessage::to_scene`] and a copy of 4.5 KB.
    pub fn on_scene(&mut self, message: &SceneMessage, now_ns: u64) -> Result<(), SceneFault> {
        let model = self.planner.model();
        self.scene_gate.see(message, model, &self.limits, now_ns)
    }

    /// Takes feedback that has arrived. Feedback about any other than the current command is
    /// ignored.
    pub fn on_feedback(&mut self, feedback: &Feedback, now_ns: u64) -> Result<(), FeedbackError> {
        let report = feedback.read()?;
        if let Some(job) = &mut self.job {
            job.hear(&report, now_ns);
        }
        Ok(())
    }

    /// The controller died, hangs, or was replaced: the outcome of its command is unknown. A stop
    /// is sent, in case it was only delayed.
    pub fn on_controller_lost(&mut self) {
        if let Some(job) = &mut self.job {
            job.on_controller_lost();
        }
    }

    /// The command of the last [`Event::Command`] could not be delivered: there is no controller,
    /// or it does not read its commands.
    pub fn on_command_undelivered(&mut self) {
        if let Some(job) = &mut self.job {
            job.on_command_undelivered();
        }
    }

    /// Does one unit of work: at most [`nsrm_core::planner::UNIT_MULTIPLY_ADDS`], or the checks of
    /// a scene, which copy 4.5 KB a few times and compare all pairs of objects.
    ///
    /// * `now_ns`: the time, on the clock of the scenes and of the feedback; if it is set back by
    ///   more than 5 ms, the current sentence ends with [`Failure::ClockSetBack`]
    pub fn poll(&mut self, now_ns: u64) -> Event {
        if now_ns.saturating_add(AHEAD_NS) < self.latest_ns {
            // The stored scene would be later than all future ones.
            self.scene_gate = SceneGate::new();
            if let Some(job) = &mut self.job {
                job.set_back(now_ns);
            }
            self.latest_ns = now_ns;
        }
        self.latest_ns = self.latest_ns.max(now_ns);
        let Some(job) = &mut self.job else {
            return Event::Waiting;
        };
        let event = job.poll(&mut self.scene_gate, &self.limits, now_ns);
        if matches!(event, Event::Ended(_)) {
            self.job = None;
        }
        event
    }
}
