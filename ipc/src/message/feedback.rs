//! What a controller answers: the outcome of a command.

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use thiserror::Error;

use super::layout::message;
use super::numbers::numbers;
use crate::executive::CommandId;

message! {
    /// The outcome of a command (service `feedback`).
    "nsrm.v1.Feedback.343e85d0c8daab6b"
    pub struct Feedback {
        /// Number of the plan, as in [`crate::message::SubGoal::plan`].
        pub plan: u64,
        /// Counts up with each feedback of one controller: a gap is a loss.
        pub sequence: u64,
        /// When the outcome occurred, nanoseconds on the sender's clock.
        pub timestamp_ns: u64,
        /// Number of the command, as in [`crate::message::SubGoal::command`].
        pub command: u32,
        /// The number of an [`Outcome`].
        pub outcome: u32,
        /// Ids of up to two objects: those in the way, or for [`Outcome::Clearing`] those that
        /// are moved aside; 0 for none.
        pub objects: [u32; 2],
    }
}

numbers! {
    /// The outcome of a command.
    "Feedback.outcome"
    pub enum Outcome {
        /// It will be executed; another outcome follows.
        Accepted = 1,
        /// The object is at its sub-goal.
        Reached = 2,
        /// No space at the sub-goal, or no collision-free path.
        NoPath = 3,
        /// The gripper did not grasp the object.
        NotGrasped = 4,
        /// The object was dropped on the way.
        Dropped = 5,
        /// Placed, but not at its sub-goal.
        Misplaced = 6,
        /// Stopped by a command, a person or a safety function.
        Stopped = 7,
        /// Another command is being executed; this one won't be.
        Busy = 8,
        /// The command is invalid, or its object isn't visible; it won't be executed.
        Impossible = 9,
        /// It was read after its deadline; it won't be executed.
        TooLate = 10,
        /// Nothing supports the object at its sub-goal, or it would fall there.
        WouldFall = 11,
        /// The object or its sub-goal is out of the arm's reach.
        OutOfReach = 12,
        /// The arm's joints do not follow their commands; the arm has stopped.
        NotFollowing = 13,
        /// Another object stands on the object.
        Covered = 14,
        /// The gripper cannot hold an object of this size.
        CannotHold = 15,
        /// Other objects are moved aside first, or the object itself is regrasped on the way;
        /// another outcome follows.
        Clearing = 16,
        /// The reference object was moved after the command was sent; the object was not
        /// grasped.
        ReferenceMoved = 17,
    }
}

impl Outcome {
    /// What happened, for a person.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Accepted => "the controller accepted the command",
            Self::Reached => "the object is at its sub-goal",
            Self::NoPath => "no collision-free path exists",
            Self::NotGrasped => "the gripper did not grasp the object",
            Self::Dropped => "the object was dropped on the way",
            Self::Misplaced => "the object was placed, but not at its sub-goal",
            Self::Stopped => "the robot was stopped",
            Self::Busy => "the controller is executing another command",
            Self::Impossible => "the controller does not see the object, or the command is invalid",
            Self::TooLate => "the controller read the command too late",
            Self::WouldFall => "the object would fall at its sub-goal",
            Self::OutOfReach => "the object or its sub-goal is out of the arm's reach",
            Self::NotFollowing => "the arm does not follow its commands and has stopped",
            Self::Covered => "another object stands on the object",
            Self::CannotHold => "the gripper cannot hold an object of this size",
            Self::Clearing => "obstacles are moved aside first",
            Self::ReferenceMoved => "the reference object was moved meanwhile",
        }
    }

    /// What a person can do about it; empty if nothing needs to be done.
    pub const fn advice(self) -> &'static str {
        match self {
            Self::Accepted | Self::Reached | Self::Clearing => "",
            Self::NoPath => "make room, and send the sentence again",
            Self::NotGrasped => "check the object and the gripper, and send the sentence again",
            Self::Dropped | Self::Misplaced => {
                "check where the object is, and send the sentence again"
            }
            Self::Stopped => "check that nobody is in danger, and send the sentence again",
            Self::Busy => "wait until it is done, or stop it",
            Self::Impossible => "see the controller's log",
            Self::TooLate => "check what delays it, and send the sentence again",
            Self::WouldFall => "ask for another place",
            Self::OutOfReach => "move the object nearer, or ask for another place",
            Self::NotFollowing => "check the arm, and restart its controller",
            Self::Covered => "ask for that object to be moved first",
            Self::CannotHold => "ask for another object",
            Self::ReferenceMoved => "leave it where it is, and send the sentence again",
        }
    }

    /// Whether it is the last outcome of the command.
    pub const fn is_end(self) -> bool {
        !matches!(self, Self::Accepted | Self::Clearing)
    }

    /// Whether a retry may succeed.
    pub const fn may_be_tried_again(self) -> bool {
        matches!(
            self,
            Self::NotGrasped | Self::Dropped | Self::Misplaced | Self::ReferenceMoved
        )
    }

    /// Whether the command may succeed once other objects have moved.
    pub const fn depends_on_others(self) -> bool {
        matches!(
            self,
            Self::NoPath
                | Self::Impossible
                | Self::WouldFall
                | Self::OutOfReach
                | Self::Covered
                | Self::CannotHold
        )
    }
}

/// A feedback message, checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// Which command.
    pub id: CommandId,
    /// The outcome.
    pub outcome: Outcome,
    /// Ids of objects in the way, or moved aside; 0 for none.
    pub objects: [u32; 2],
    /// When the outcome occurred, nanoseconds on the sender's clock.
    pub timestamp_ns: u64,
}

/// Why a feedback message is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FeedbackError {
    /// Unknown outcome.
    #[error("feedback: unknown outcome {0}")]
    Outcome(u32),
    /// Commands count from 1.
    #[error("feedback: command 0; commands count from 1")]
    NoCommand,
}

impl Feedback {
    /// Checks the message.
    ///
    /// ```
    /// use nsrm_ipc::message::{Feedback, FeedbackError, Outcome};
    ///
    /// let mut feedback = Feedback {
    ///     plan: 9,
    ///     sequence: 1,
    ///     timestamp_ns: 5,
    ///     command: 2,
    ///     outcome: Outcome::Reached as u32,
    ///     objects: [0; 2],
    /// };
    /// assert_eq!(feedback.read()?.outcome, Outcome::Reached);
    /// feedback.outcome = 99; // a received message may contain anything
    /// assert_eq!(feedback.read(), Err(FeedbackError::Outcome(99)));
    /// # Ok::<(), FeedbackError>(())
    /// ```
    pub fn read(&self) -> Result<Report, FeedbackError> {
        if self.command == 0 {
            return Err(FeedbackError::NoCommand);
        }
        let outcome =
            Outcome::from_number(self.outcome).ok_or(FeedbackError::Outcome(self.outcome))?;
        Ok(Report {
            id: CommandId {
                plan: self.plan,
                command: self.command,
            },
            outcome,
            objects: self.objects,
            timestamp_ns: self.timestamp_ns,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{CommandId, Feedback, FeedbackError, Outcome};

    fn feedback(command: u32, outcome: u32) -> Feedback {
        Feedback {
            plan: 7,
            sequence: 1,
            timestamp_ns: 2,
            command,
            outcome,
            objects: [5, 0],
        }
    }

    #[test]
    fn outcomes_come_back_and_other_numbers_are_refused() {
        for (number, outcome) in (1..).zip(Outcome::ALL) {
            let report = feedback(3, number).read().unwrap();
            let (plan, command) = (7, 3);
            assert_eq!(report.id, CommandId { plan, command });
            assert_eq!((report.outcome, report.timestamp_ns), (outcome, 2));
            assert_eq!(report.objects, [5, 0]);
        }
        for number in [0, 18, u32::MAX] {
            let refused = feedback(3, number).read();
            assert_eq!(refused, Err(FeedbackError::Outcome(number)));
        }
        assert_eq!(feedback(0, 2).read(), Err(FeedbackError::NoCommand));
    }
}
