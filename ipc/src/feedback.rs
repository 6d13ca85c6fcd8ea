//! What a controller answers: how a sub-goal went.

use core::fmt;

use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::MAX_STEPS;

use crate::layout::message;

message! {
    /// How a sub-goal went (service `feedback`).
    "nsrm.v1.Feedback.0299abb85bcfb11c"
    pub struct Feedback {
        /// Number of the plan, as in [`crate::SubGoal::plan`].
        pub plan: u64,
        /// Counts up with each feedback of one controller: a gap is a loss.
        pub sequence: u64,
        /// When it ended, nanoseconds on the sender's clock.
        pub timestamp_ns: u64,
        /// Place of the sub-goal in the plan, from 0.
        pub step: u32,
        /// How it went: the number of an [`Outcome`].
        pub outcome: u32,
        /// How often it was tried.
        pub attempts: u32,
        /// Always 0.
        pub reserved: u32,
    }
}

/// How a sub-goal went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// Received; not yet done.
    Accepted = 1,
    /// The object stands where it should.
    Reached = 2,
    /// No way there without a collision.
    NoPath = 3,
    /// The gripper did not get hold of the object.
    NotGrasped = 4,
    /// The object was lost on the way.
    Dropped = 5,
    /// Set down, but not where it should stand.
    Misplaced = 6,
    /// Stopped by a person or a safety function.
    Stopped = 7,
}

/// Why a feedback is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedbackError {
    /// No outcome has this number.
    Outcome(u32),
    /// No plan has this many steps.
    Step(u32),
}

impl fmt::Display for FeedbackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outcome(number) => write!(f, "feedback: {number} is no outcome"),
            Self::Step(step) => write!(
                f,
                "feedback: step {step}; a plan has at most {MAX_STEPS}, counted from 0"
            ),
        }
    }
}

impl core::error::Error for FeedbackError {}

impl TryFrom<&Feedback> for Outcome {
    type Error = FeedbackError;

    fn try_from(feedback: &Feedback) -> Result<Self, FeedbackError> {
        if feedback.step >= MAX_STEPS as u32 {
            return Err(FeedbackError::Step(feedback.step));
        }
        Ok(match feedback.outcome {
            1 => Self::Accepted,
            2 => Self::Reached,
            3 => Self::NoPath,
            4 => Self::NotGrasped,
            5 => Self::Dropped,
            6 => Self::Misplaced,
            7 => Self::Stopped,
            other => return Err(FeedbackError::Outcome(other)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Feedback, FeedbackError, Outcome};

    fn feedback(step: u32, outcome: u32) -> Feedback {
        Feedback {
            plan: 7,
            sequence: 1,
            timestamp_ns: 2,
            step,
            outcome,
            attempts: 1,
            reserved: 0,
        }
    }

    #[test]
    fn outcomes_come_back_and_other_numbers_are_refused() {
        for outcome in [
            Outcome::Accepted,
            Outcome::Reached,
            Outcome::NoPath,
            Outcome::NotGrasped,
            Outcome::Dropped,
            Outcome::Misplaced,
            Outcome::Stopped,
        ] {
            let message = feedback(7, outcome as u32);
            assert_eq!(Outcome::try_from(&message), Ok(outcome));
        }
        for number in [0, 8, u32::MAX] {
            let refused = Outcome::try_from(&feedback(0, number));
            assert_eq!(refused, Err(FeedbackError::Outcome(number)));
        }
        let refused = Outcome::try_from(&feedback(8, 2));
        assert_eq!(refused, Err(FeedbackError::Step(8)));
    }
}
