//! The loop that closes: parses a sentence, grounds the step that is next in the
//! scene as it is observed, commands it, looks at what came of it, and goes on,
//! tries again or gives up with a reason.
//!
//! An [`Executive`] knows no process and no clock: it is told scenes, feedback and
//! the time, and says what to do by [`Executive::poll`], a bounded piece of work a
//! call. It never allocates.
//!
//! A sentence ends with [`Event::Ended`]. If its last command may still be accepted or carried
//! out then, [`Event::Stop`] has come before.

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

use crate::message::{Feedback, FeedbackError, SceneMessage};
use job::Job;
use scene_gate::{AHEAD_NS, SceneGate};

/// A sentence, as long as it may be.
pub type Sentence = String<MAX_SENTENCE_BYTES>;

/// How far a sentence is to be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Say what would be done, and do nothing.
    PlanOnly,
    /// Ground each step in the scene observed after the one before it.
    ClosedLoop,
    /// Carry out the plan made at the beginning, as in the paper, without looking.
    OpenLoop,
}

/// Who a command is, among all of one planner's and of those started before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CommandId {
    /// Number of the plan; plans of later planners have greater ones.
    pub plan: u64,
    /// Counts the plan's commands from 1; a step tried again has another.
    pub command: u32,
}

/// What the controller is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Who the command is.
    pub id: CommandId,
    /// Until when it may be begun, nanoseconds: then it is given up, and a stop
    /// follows.
    pub until_ns: u64,
    /// Which step of the program, from 0.
    pub step: u8,
    /// How many steps the program has.
    pub steps: u8,
    /// Which object, and where to.
    pub planned: PlannedStep,
    /// Ids of what is to stay where it is besides the reference: what the steps that are done have
    /// put somewhere, and what they have put it beside or on; 0 for none.
    pub keep: [u32; MAX_OBJECTS],
}

/// What a call of [`Executive::poll`] has come to.
#[derive(Debug, Clone, PartialEq)]
#[must_use = "a command or a result would be lost"]
// The largest is handed on once a plan.
#[allow(clippy::large_enum_variant)]
pub enum Event {
    /// Nothing can be done until something arrives or time goes by.
    Waiting,
    /// A piece of work was done; more is left.
    Working,
    /// The sentence was understood and, from the step that is next on, grounded.
    Planned(Plan),
    /// To be sent to the controller.
    Command(Command),
    /// To be sent to the controller: this command is no longer wanted.
    Stop(CommandId),
    /// Before a step's object is carried to its sub-goal, something else is.
    Clearing {
        /// Which, from 0.
        step: u8,
        /// Id of the step's object.
        object: u32,
        /// Ids of what is moved aside first; the step's own object, if it is set down on the
        /// way; 0 for none.
        first: [u32; 2],
    },
    /// A step did what it should.
    Reached {
        /// Which, from 0.
        step: u8,
        /// How far from its sub-goal the object was seen, metres; without looking
        /// not a number.
        off_m: f32,
    },
    /// A step will be tried again.
    Again {
        /// Which, from 0.
        step: u8,
        /// What went wrong.
        why: Failure,
    },
    /// The sentence was carried out, or why not.
    Ended(Result<(), Failure>),
}

/// Another sentence is being carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Busy {
    /// Number of its plan.
    pub plan: u64,
}

impl core::fmt::Display for Busy {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "another sentence (plan {}) is being executed: wait for it, or cancel it",
            self.plan
        )
    }
}

impl core::error::Error for Busy {}

/// Carries out one sentence at a time.
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
    /// The latest time that it was told.
    latest_ns: u64,
}

impl<'m> Executive<'m> {
    /// With nothing to do.
    ///
    /// * `first_plan`: number of its first plan; above those of any executive
    ///   before it that the same controller has heard, such as the monotonic time
    ///   in nanoseconds
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

    /// Number of the plan that is being carried out.
    pub fn plan(&self) -> Option<u64> {
        self.job.as_ref().map(|job| job.number)
    }

    /// Begins with a sentence; gives the number of its plan.
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

    /// The sentence is no longer wanted: what moves is stopped, and
    /// [`Failure::Cancelled`] ends it.
    pub fn cancel(&mut self) {
        if let Some(job) = &mut self.job {
            job.cancel();
        }
    }

    /// A scene has arrived; says why it won't be looked at, if so.
    ///
    /// Cost: the checks of [`SceneMessage::to_scene`] and a copy of 4.5 KB.
    pub fn on_scene(&mut self, message: &SceneMessage, now_ns: u64) -> Result<(), SceneFault> {
        let model = self.planner.model();
        self.scene_gate.see(message, model, &self.limits, now_ns)
    }

    /// Feedback has arrived. What is about no command that is waited for changes
    /// nothing.
    pub fn on_feedback(&mut self, feedback: &Feedback, now_ns: u64) -> Result<(), FeedbackError> {
        let report = feedback.read()?;
        if let Some(job) = &mut self.job {
            job.hear(&report, now_ns);
        }
        Ok(())
    }

    /// The controller died, hangs, or is another one than before: what it was
    /// doing has an unknown end. It is told to stop, in case that it only was held up.
    pub fn on_controller_lost(&mut self) {
        if let Some(job) = &mut self.job {
            job.on_controller_lost();
        }
    }

    /// The command of the last [`Event::Command`] could not be sent: no controller
    /// is there, or it doesn't take its commands.
    pub fn on_command_undelivered(&mut self) {
        if let Some(job) = &mut self.job {
            job.on_command_undelivered();
        }
    }

    /// Does one piece of work, at most [`nsrm_core::planner::UNIT_MULTIPLY_ADDS`], or takes in a
    /// scene: a few copies of 4.5 KB, its checks, and each object compared with each other one.
    ///
    /// * `now_ns`: the time, on the clock of the scenes and of the feedback; when it is set back
    ///   by more than 5 ms, what is under way ends with [`Failure::ClockSetBack`]
    pub fn poll(&mut self, now_ns: u64) -> Event {
        if now_ns.saturating_add(AHEAD_NS) < self.latest_ns {
            // Its scene would be later than all that come.
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
