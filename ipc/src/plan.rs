//! A sentence asks, a plan or a refusal answers (service `plan`).

use core::fmt;

use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::planner::Plan;
use nsrm_core::{MAX_SENTENCE_BYTES, MAX_STEPS, Model, Refusal};

use crate::layout::message;
use crate::sub_goal::{SubGoal, SubGoalError};
use crate::text::{self, Clamped, TextFault};

/// Bytes of a refusal's kind.
pub const MAX_KIND_BYTES: usize = 32;
/// Bytes of a message for a person; a longer one is cut.
pub const MAX_MESSAGE_BYTES: usize = 1024;

/// [`PlanReply::status`]: there is a plan.
const PLANNED: u32 = 1;
/// [`PlanReply::status`]: refused.
const REFUSED: u32 = 2;

message! {
    /// Asks for a plan in the latest scene.
    "nsrm.v1.PlanRequest.583a507295a05d5e"
    pub struct PlanRequest {
        /// Number of the request, the asker's own.
        pub sequence: u64,
        /// Bytes of the sentence.
        pub sentence_length: u32,
        /// Always 0.
        pub reserved: u32,
        /// The sentence in UTF-8.
        pub sentence: [u8; MAX_SENTENCE_BYTES],
    }
}

message! {
    /// Answers a [`PlanRequest`]: a plan, or why there is none.
    "nsrm.v1.PlanReply.fd36ec800a673c92"
    pub struct PlanReply {
        /// Number of the request.
        pub request: u64,
        /// [`nsrm_core::scene::SceneHeader::sequence`] of the scene that was
        /// planned in.
        pub scene: u64,
        /// 1: planned; 2: refused.
        pub status: u32,
        /// How many of `sub_goals` are there; at least one if planned, else 0.
        pub count: u32,
        /// Bytes of the refusal's kind; 0 if planned.
        pub kind_length: u32,
        /// Bytes of the message; 0 if planned.
        pub message_length: u32,
        /// The refusal's kind, as [`nsrm_core::Refusal::kind`] names it.
        pub kind: [u8; MAX_KIND_BYTES],
        /// The refusal for a person, in UTF-8.
        pub message: [u8; MAX_MESSAGE_BYTES],
        /// The sub-goals, in the order in which they are carried out.
        pub sub_goals: [SubGoal; MAX_STEPS],
    }
}

/// Why a request is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanRequestError {
    /// More bytes than a request holds.
    TooLong {
        /// Bytes of the sentence.
        length: usize,
    },
    /// The sentence is not UTF-8.
    Utf8,
}

impl fmt::Display for PlanRequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { length } => write!(
                f,
                "plan request: a sentence of {length} bytes, at most {MAX_SENTENCE_BYTES} are read"
            ),
            Self::Utf8 => f.write_str("plan request: the sentence is not UTF-8"),
        }
    }
}

impl core::error::Error for PlanRequestError {}

impl PlanRequest {
    /// Asks for a plan for this sentence.
    pub fn new(sequence: u64, sentence: &str) -> Result<Self, PlanRequestError> {
        let length = sentence.len();
        if length > MAX_SENTENCE_BYTES {
            return Err(PlanRequestError::TooLong { length });
        }
        let text = Clamped::new(sentence);
        Ok(Self {
            sequence,
            sentence_length: text.length,
            reserved: 0,
            sentence: text.bytes,
        })
    }

    /// The sentence.
    pub fn sentence(&self) -> Result<&str, PlanRequestError> {
        text::read(self.sentence_length, &self.sentence).map_err(|fault| match fault {
            TextFault::Length => PlanRequestError::TooLong {
                length: self.sentence_length as usize,
            },
            TextFault::Utf8 => PlanRequestError::Utf8,
        })
    }
}

/// What an answer says, its parts still in place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanResult<'a> {
    /// What is to be done, checked.
    Planned(&'a [SubGoal]),
    /// Why nothing will be done.
    Refused {
        /// As [`nsrm_core::Refusal::kind`] names it.
        kind: &'a str,
        /// For a person.
        message: &'a str,
    },
}

/// Why an answer is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanReplyError {
    /// Neither planned nor refused.
    Status(u32),
    /// A plan of no steps, or of more than there may be.
    Count(u32),
    /// A sub-goal is none.
    SubGoal {
        /// Its place, from 0.
        index: u32,
        /// What is wrong.
        error: SubGoalError,
    },
    /// A sub-goal that says it belongs to another plan or place.
    OtherPlan {
        /// Its place, from 0.
        index: u32,
    },
    /// The refusal's kind or message is no text.
    Text,
}

impl fmt::Display for PlanReplyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Status(number) => write!(f, "plan reply: {number} is no status"),
            Self::Count(count) => write!(
                f,
                "plan reply: a plan of {count} steps, from 1 to {MAX_STEPS} are possible"
            ),
            Self::SubGoal { index, error } => {
                write!(f, "plan reply: step {index}: {error}")
            }
            Self::OtherPlan { index } => {
                write!(f, "plan reply: step {index} belongs to another plan")
            }
            Self::Text => f.write_str("plan reply: the refusal is not UTF-8, or too long"),
        }
    }
}

impl core::error::Error for PlanReplyError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::SubGoal { error, .. } => Some(error),
            _ => None,
        }
    }
}

impl PlanReply {
    const EMPTY: Self = Self {
        request: 0,
        scene: 0,
        status: 0,
        count: 0,
        kind_length: 0,
        message_length: 0,
        kind: [0; MAX_KIND_BYTES],
        message: [0; MAX_MESSAGE_BYTES],
        sub_goals: [SubGoal::EMPTY; MAX_STEPS],
    };

    /// The answer with a plan.
    ///
    /// * `request`: number of the request
    /// * `scene`: number of the scene
    pub fn planned(request: u64, scene: u64, plan: &Plan) -> Self {
        let steps = plan.steps();
        // At most MAX_STEPS.
        let count = steps.len() as u32;
        let mut reply = Self {
            request,
            scene,
            status: PLANNED,
            count,
            ..Self::EMPTY
        };
        for (index, (place, step)) in (0..).zip(reply.sub_goals.iter_mut().zip(steps)) {
            let pose = &step.sub_goal.pose;
            *place = SubGoal {
                plan: request,
                step: index,
                steps: count,
                action: step.action.into(),
                object_id: step.object.object,
                reference_id: step.reference.object,
                confidence: step.confidence.joint(),
                position: pose.translation.vector.into(),
                orientation: pose.rotation.coords.into(),
                location: step.location,
            };
        }
        reply
    }

    /// The answer with a refusal.
    ///
    /// * `model`, `sentence`: those that were refused, for the message
    pub fn refused(
        request: u64,
        scene: u64,
        refusal: &Refusal,
        model: &Model<'_>,
        sentence: &str,
    ) -> Self {
        let kind = Clamped::new(refusal.kind());
        let message = Clamped::new(refusal.in_context(model, sentence));
        Self {
            request,
            scene,
            status: REFUSED,
            kind_length: kind.length,
            message_length: message.length,
            kind: kind.bytes,
            message: message.bytes,
            ..Self::EMPTY
        }
    }

    /// What the answer says, checked.
    pub fn read(&self) -> Result<PlanResult<'_>, PlanReplyError> {
        match self.status {
            PLANNED => self.read_plan().map(PlanResult::Planned),
            REFUSED => {
                let kind = text::read(self.kind_length, &self.kind);
                let message = text::read(self.message_length, &self.message);
                match (kind, message) {
                    (Ok(kind), Ok(message)) => Ok(PlanResult::Refused { kind, message }),
                    _ => Err(PlanReplyError::Text),
                }
            }
            other => Err(PlanReplyError::Status(other)),
        }
    }

    fn read_plan(&self) -> Result<&[SubGoal], PlanReplyError> {
        let sub_goals = usize::try_from(self.count)
            .ok()
            .and_then(|count| self.sub_goals.get(..count))
            .filter(|sub_goals| !sub_goals.is_empty())
            .ok_or(PlanReplyError::Count(self.count))?;
        for (index, sub_goal) in (0..).zip(sub_goals) {
            sub_goal
                .check()
                .map_err(|error| PlanReplyError::SubGoal { index, error })?;
            let place = (sub_goal.plan, sub_goal.step, sub_goal.steps);
            if place != (self.request, index, self.count) {
                return Err(PlanReplyError::OtherPlan { index });
            }
        }
        Ok(sub_goals)
    }
}

#[cfg(test)]
mod tests {
    use super::{
        MAX_SENTENCE_BYTES, PLANNED, PlanReply, PlanReplyError, PlanRequest, PlanRequestError,
        PlanResult, REFUSED,
    };
    use crate::sub_goal::{SubGoalError, tests::sub_goal};

    #[test]
    fn a_sentence_comes_back_or_is_too_long() {
        let request = PlanRequest::new(3, "put the rötliche block …").unwrap();
        assert_eq!(request.sentence(), Ok("put the rötliche block …"));
        let longest = "x".repeat(MAX_SENTENCE_BYTES);
        let request = PlanRequest::new(3, &longest).unwrap();
        assert_eq!(request.sentence(), Ok(longest.as_str()));
        let length = MAX_SENTENCE_BYTES + 1;
        let refused = PlanRequest::new(3, &"x".repeat(length));
        assert_eq!(refused, Err(PlanRequestError::TooLong { length }));
    }

    #[test]
    fn a_received_sentence_is_checked() {
        let mut request = PlanRequest::new(3, "put").unwrap();
        request.sentence_length = u32::MAX;
        let length = u32::MAX as usize;
        assert_eq!(
            request.sentence(),
            Err(PlanRequestError::TooLong { length })
        );
        request.sentence_length = 3;
        request.sentence[1] = 0xff;
        assert_eq!(request.sentence(), Err(PlanRequestError::Utf8));
    }

    fn reply() -> PlanReply {
        let mut reply = PlanReply {
            request: 7,
            status: PLANNED,
            count: 2,
            ..PlanReply::EMPTY
        };
        reply.sub_goals[0] = sub_goal();
        reply.sub_goals[0].step = 0;
        reply.sub_goals[1] = sub_goal();
        reply
    }

    #[test]
    fn a_plan_is_checked_step_by_step() {
        let good = reply();
        assert_eq!(good.read(), Ok(PlanResult::Planned(&good.sub_goals[..2])));
        for count in [0, 9, u32::MAX] {
            let broken = PlanReply { count, ..good };
            assert_eq!(broken.read(), Err(PlanReplyError::Count(count)));
        }
        let mut broken = good;
        broken.sub_goals[1].position[0] = f32::NAN;
        let error = SubGoalError::NotFinite;
        assert_eq!(
            broken.read(),
            Err(PlanReplyError::SubGoal { index: 1, error })
        );
        let mut broken = good;
        broken.sub_goals[1].plan = 8;
        assert_eq!(broken.read(), Err(PlanReplyError::OtherPlan { index: 1 }));
        let broken = PlanReply { status: 0, ..good };
        assert_eq!(broken.read(), Err(PlanReplyError::Status(0)));
    }

    #[test]
    fn a_refusals_text_is_checked() {
        let mut refused = PlanReply {
            status: REFUSED,
            kind_length: 2,
            ..PlanReply::EMPTY
        };
        refused.kind[..2].copy_from_slice(b"no");
        let (kind, message) = ("no", "");
        assert_eq!(refused.read(), Ok(PlanResult::Refused { kind, message }));
        refused.message_length = 2000;
        assert_eq!(refused.read(), Err(PlanReplyError::Text));
    }
}
