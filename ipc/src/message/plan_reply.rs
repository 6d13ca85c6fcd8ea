//! Replies to a request (services `plan` and `answer`): one [`PlanReply`] per event, of which the
//! last one reports the result.

use core::fmt;

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::{MAX_STEPS, Model, Plan};
use thiserror::Error;

use super::layout::message;
use super::numbers::numbers;
use super::step::StepMessage;
use super::text::{self, Clamped};
use crate::executive::{Event, Failure};

/// Bytes of a text for a person; a longer one is cut.
pub const MAX_MESSAGE_BYTES: usize = 1024;

message! {
    /// An event in the execution of a `PlanRequest`.
    "nsrm.v1.PlanReply.a2af30d8382126dc"
    pub struct PlanReply {
        /// The client.
        pub client: u64,
        /// Number of the request.
        pub request: u64,
        /// Number of the plan; 0 if there is none.
        pub plan: u64,
        /// Number of the reply to its request, from 1: a gap is a loss.
        pub number: u32,
        /// The event: the number of a [`Status`].
        pub status: u32,
        /// Which step it is about, from 0.
        pub step: u32,
        /// How many steps the program has; at least 1 with [`Status::Planned`], else 0.
        pub count: u32,
        /// Why it failed: place in [`REASONS`] from 1; 0 if it did not fail.
        pub reason: u32,
        /// How far from its sub-goal an object was observed, metres.
        pub off_m: f32,
        /// Bytes of the message.
        pub message_length: u32,
        /// Always 0.
        pub reserved: u32,
        /// Text for a person, UTF-8: the program in the paper's notation with [`Status::Planned`],
        /// and a line for each misspelt word that says what it was read as; else the reason.
        pub message: [u8; MAX_MESSAGE_BYTES],
        /// The program's steps with [`Status::Planned`].
        pub steps: [StepMessage; MAX_STEPS],
    }
}

/// Why a request failed: the names of [`nsrm_core::Refusal::kind`] and [`Failure::kind`], and
/// reasons of the planner's node. [`PlanReply::reason`] is a place in this list, from 1.
pub const REASONS: [&str; 48] = [
    "no_words",
    "unknown_word",
    "sentence_too_long",
    "too_many_concepts",
    "too_many_steps",
    "too_many_references",
    "incomplete_step",
    "same_reference",
    "unsure",
    "no_such_object",
    "ambiguous",
    "same_object",
    "not_finite",
    "outside_work_space",
    "other_model",
    "invalid_model",
    "no_scene",
    "not_accepted",
    "no_outcome",
    "controller_lost",
    "unsuccessful",
    "not_there",
    "not_seen",
    "cancelled",
    "cancelled_unconfirmed",
    "busy",
    "bad_request",
    "no_such_request",
    "stopping",
    "unanswered",
    "clock_set_back",
    "conflicting_values",
    "calibration",
    "parsed_by_other_model",
    "low_confidence",
    "unclear_words",
    "too_many_relations",
    "outside_training_view",
    "other_object",
    "unclear_pronoun",
    "several_references",
    "other_number",
    "only_on_table",
    "already_on_table",
    "no_room_on_table",
    "hidden_reference",
    "not_on_table",
    OTHER,
];

/// Any other reason: the message explains it.
const OTHER: &str = "other";

numbers! {
    /// An event in the execution of a request.
    "PlanReply.status"
    pub enum Status {
        /// It was parsed and grounded; repeated before each step that is grounded again.
        Planned = 1,
        /// A step was sent to the controller.
        Commanded = 2,
        /// A step succeeded.
        Reached = 3,
        /// A step failed and is retried.
        Again = 4,
        /// The sentence is done. The last reply.
        Done = 5,
        /// The request was refused or has failed. The last reply.
        Failed = 6,
        /// Other objects are moved aside before a step's object is moved.
        Clearing = 7,
    }
}

/// The content of a reply, in place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reply<'a> {
    /// The program, with its remaining steps grounded.
    Planned {
        /// All steps of the program.
        steps: &'a [StepMessage],
        /// The program in the paper's notation, and a line for each misspelt word that says what it
        /// was read as.
        program: &'a str,
    },
    /// A step was sent to the controller.
    Commanded {
        /// Which step, from 0.
        step: u32,
    },
    /// Other objects are moved aside before a step's object is moved.
    Clearing {
        /// Which step, from 0.
        step: u32,
        /// Text for a person: what is moved.
        message: &'a str,
    },
    /// A step succeeded.
    Reached {
        /// Which step, from 0.
        step: u32,
        /// How far from its sub-goal its object was observed, metres; NaN if it was not observed.
        off_m: f32,
    },
    /// A step is retried.
    Again {
        /// Which step, from 0.
        step: u32,
        /// One of [`REASONS`].
        reason: &'static str,
        /// Text for a person.
        message: &'a str,
    },
    /// The sentence is done.
    Done,
    /// The request was refused or has failed.
    Failed {
        /// One of [`REASONS`].
        reason: &'static str,
        /// Text for a person.
        message: &'a str,
    },
}

/// Why a reply is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PlanReplyError {
    /// Unknown status.
    #[error("plan reply: unknown status {0}")]
    Status(u32),
    /// A program without steps, or with too many.
    #[error("plan reply: a program of {0} steps; it must have from 1 to {MAX_STEPS}")]
    Count(u32),
    /// A step number that no program has.
    #[error("plan reply: step {0}; a program has at most {MAX_STEPS}, counted from 0")]
    Step(u32),
    /// An invalid step.
    #[error(
        "plan reply: step {step} has too many concepts or relations, a number that is not finite, or a \
         quaternion not of length 1"
    )]
    Broken {
        /// Which step, from 0.
        step: u32,
    },
    /// Unknown reason.
    #[error("plan reply: unknown reason {0}")]
    Reason(u32),
    /// The message is not valid text.
    #[error("plan reply: the message is not UTF-8, or too long")]
    Text,
}

/// The request that a reply belongs to, and the reply's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReplyTo {
    /// The client.
    pub client: u64,
    /// Number of the request.
    pub request: u64,
    /// Number of the plan; 0 if there is none.
    pub plan: u64,
    /// Number of the reply to its request, from 1.
    pub number: u32,
}

/// A plan's program, and a line for each misspelt word.
struct Understood<'a> {
    plan: &'a Plan,
    model: &'a Model<'a>,
    sentence: &'a str,
}

impl fmt::Display for Understood<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.plan.program().notation(self.model))?;
        for correction in self.plan.corrections() {
            let explained = correction.explain(self.model, self.sentence);
            write!(f, "\n{explained}")?;
        }
        Ok(())
    }
}

impl PlanReply {
    const fn new(to: ReplyTo, status: Status) -> Self {
        Self {
            client: to.client,
            request: to.request,
            plan: to.plan,
            number: to.number,
            status: status as u32,
            step: 0,
            count: 0,
            reason: 0,
            off_m: 0.0,
            message_length: 0,
            reserved: 0,
            message: [0; MAX_MESSAGE_BYTES],
            steps: [StepMessage::EMPTY; MAX_STEPS],
        }
    }

    /// The reply for an event, if the client is told about it.
    ///
    /// * `sentence`: the sentence of the request, for the message
    pub fn about(to: ReplyTo, event: &Event, model: &Model<'_>, sentence: &str) -> Option<Self> {
        Some(match event {
            Event::Waiting | Event::Working | Event::Stop(_) => return None,
            Event::Planned(plan) => Self::planned(to, plan, model, sentence),
            Event::Command(command) => Self {
                step: command.step.into(),
                ..Self::new(to, Status::Commanded)
            },
            &Event::Clearing {
                step,
                object,
                first,
            } => Self {
                step: step.into(),
                ..Self::new(to, Status::Clearing).saying(MovedFirst { object, first })
            },
            &Event::Reached { step, off_m } => Self {
                step: step.into(),
                off_m,
                ..Self::new(to, Status::Reached)
            },
            Event::Again { step, why } => Self {
                step: (*step).into(),
                ..Self::failed(to, Status::Again, why, model, sentence)
            },
            Event::Ended(Ok(())) => Self::new(to, Status::Done),
            Event::Ended(Err(why)) => Self::failed(to, Status::Failed, why, model, sentence),
        })
    }

    /// A refusal by the node itself.
    ///
    /// * `reason`: one of [`REASONS`]
    ///
    /// ```
    /// use nsrm_ipc::message::{PlanReply, Reply, ReplyTo};
    ///
    /// let to = ReplyTo { client: 1, request: 7, plan: 0, number: 1 };
    /// let reply = PlanReply::refused(to, "busy", "another sentence is being carried out");
    /// let Ok(Reply::Failed { reason, message }) = reply.read() else {
    ///     panic!("it failed");
    /// };
    /// assert_eq!((reason, message), ("busy", "another sentence is being carried out"));
    /// ```
    pub fn refused(to: ReplyTo, reason: &str, message: impl fmt::Display) -> Self {
        Self::new(to, Status::Failed).because(reason, message)
    }

    fn failed(
        to: ReplyTo,
        status: Status,
        why: &Failure,
        model: &Model<'_>,
        sentence: &str,
    ) -> Self {
        let reply = Self::new(to, status);
        match why {
            Failure::Refused(refusal) => {
                reply.because(why.kind(), refusal.in_context(model, sentence))
            }
            _ => reply.because(why.kind(), why),
        }
    }

    fn planned(to: ReplyTo, plan: &Plan, model: &Model<'_>, sentence: &str) -> Self {
        let program = plan.program().steps();
        let mut reply = Self {
            // At most MAX_STEPS.
            count: program.len() as u32,
            ..Self::new(to, Status::Planned)
        }
        .saying(Understood {
            plan,
            model,
            sentence,
        });
        for (place, step) in reply.steps.iter_mut().zip(program) {
            *place = StepMessage::understood(step);
        }
        let left = reply.steps.iter_mut().skip(plan.first());
        for (place, planned) in left.zip(plan.steps()) {
            place.ground(planned);
        }
        reply
    }

    fn because(self, reason: &str, message: impl fmt::Display) -> Self {
        let place = |reason| REASONS.iter().position(|known| *known == reason);
        // Every reason is in the list: a test here checks all failures, one in
        // `tests/tests/refusals.rs` all refusals. But a later core may have more.
        let place = place(reason).or_else(|| place(OTHER));
        Self {
            // They fit: there are few.
            reason: place.map_or(0, |place| place as u32 + 1),
            ..self.saying(message)
        }
    }

    fn saying(self, message: impl fmt::Display) -> Self {
        let text = Clamped::new(message);
        Self {
            message_length: text.length,
            message: text.bytes,
            ..self
        }
    }

    /// Checks the reply and returns its content.
    pub fn read(&self) -> Result<Reply<'_>, PlanReplyError> {
        let message = text::read(self.message_length, &self.message);
        let message = message.map_err(|_| PlanReplyError::Text)?;
        if self.step >= MAX_STEPS as u32 {
            return Err(PlanReplyError::Step(self.step));
        }
        let reason = || {
            let place = self.reason.checked_sub(1);
            place
                .and_then(|place| REASONS.get(place as usize).copied())
                .ok_or(PlanReplyError::Reason(self.reason))
        };
        let step = self.step;
        let status = Status::from_number(self.status).ok_or(PlanReplyError::Status(self.status))?;
        Ok(match status {
            Status::Planned => Reply::Planned {
                steps: self.read_steps()?,
                program: message,
            },
            Status::Commanded => Reply::Commanded { step },
            Status::Clearing => Reply::Clearing { step, message },
            Status::Reached => Reply::Reached {
                step,
                off_m: self.off_m,
            },
            Status::Again => Reply::Again {
                step,
                reason: reason()?,
                message,
            },
            Status::Done => Reply::Done,
            Status::Failed => Reply::Failed {
                reason: reason()?,
                message,
            },
        })
    }

    fn read_steps(&self) -> Result<&[StepMessage], PlanReplyError> {
        let steps = usize::try_from(self.count)
            .ok()
            .and_then(|count| self.steps.get(..count))
            .filter(|steps| !steps.is_empty())
            .ok_or(PlanReplyError::Count(self.count))?;
        for (index, step) in (0..).zip(steps) {
            if !step.makes_sense() {
                return Err(PlanReplyError::Broken { step: index });
            }
        }
        Ok(steps)
    }
}

/// Text for a person: what is moved before a step's object.
struct MovedFirst {
    object: u32,
    first: [u32; 2],
}

impl fmt::Display for MovedFirst {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let object = self.object;
        match self.first {
            [0, 0] => write!(f, "obstacles to object {object} are moved aside first"),
            [own, 0] | [0, own] if own == object => {
                write!(f, "object {object} is set down on the way, to regrasp it")
            }
            [other, 0] | [0, other] => write!(
                f,
                "object {other} is in the way of object {object} and is moved aside first"
            ),
            [one, other] => write!(
                f,
                "objects {one} and {other} are in the way of object {object} and are moved \
                 aside first"
            ),
        }
    }
}

#[cfg(test)]
mod tests;
