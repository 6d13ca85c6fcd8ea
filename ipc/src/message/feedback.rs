//! What a controller answers: how a sub-goal went.

use core::fmt;

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;

use super::layout::message;
use super::numbers::numbers;
use crate::executive::CommandId;

message! {
    /// How a command went (service `feedback`).
    "nsrm.v1.Feedback.343e85d0c8daab6b"
    pub struct Feedback {
        /// Number of the plan, as in [`crate::message::SubGoal::plan`].
        pub plan: u64,
        /// Counts up with each feedback of one controller: a gap is a loss.
        pub sequence: u64,
        /// When it was so, nanoseconds on the sender's clock.
        pub timestamp_ns: u64,
        /// Number of the command, as in [`crate::message::SubGoal::command`].
        pub command: u32,
        /// How it went: the number of an [`Outcome`].
        pub outcome: u32,
        /// Ids of up to two objects: those that stood in its way; those that are moved out
        /// of it, of [`Outcome::Clearing`]; 0 for none.
        pub objects: [u32; 2],
    }
}

numbers! {
    /// How a command went.
    "Feedback.outcome"
    pub enum Outcome {
        /// It will be carried out; another outcome follows.
        Accepted = 1,
        /// The object stands where it should.
        Reached = 2,
        /// No room or no way there without a collision.
        NoPath = 3,
        /// The gripper did not get hold of the object.
        NotGrasped = 4,
        /// The object was lost on the way.
        Dropped = 5,
        /// Set down, but not where it should stand.
        Misplaced = 6,
        /// Stopped by a command, a person or a safety function.
        Stopped = 7,
        /// Another command is being carried out; this one won't be.
        Busy = 8,
        /// The command makes no sense, or its object isn't seen; it won't be carried
        /// out.
        Impossible = 9,
        /// It was read after its time; it won't be carried out.
        TooLate = 10,
        /// Nothing bears the object at its sub-goal, or it would fall there.
        WouldFall = 11,
        /// The object or its sub-goal is beyond the arm's reach.
        OutOfReach = 12,
        /// The arm's joints do not follow; it stands still where it is.
        NotFollowing = 13,
        /// Something stands on the object.
        Covered = 14,
        /// The hand can't hold an object of its size.
        CannotHold = 15,
        /// Other objects are moved aside first, or the object itself is set down on the way;
        /// another outcome follows.
        Clearing = 16,
        /// What the object was to be beside or on was moved since the command was given; the
        /// object was not grasped.
        ReferenceMoved = 17,
    }
}

impl Outcome {
    /// What happened, for a person.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Accepted => "the controller has accepted it",
            Self::Reached => "the object stands where it should",
            Self::NoPath => "there is no way there without a collision",
            Self::NotGrasped => "the gripper did not get hold of the object",
            Self::Dropped => "the object was lost on the way",
            Self::Misplaced => "the object was set down, but not where it should stand",
            Self::Stopped => "the robot was stopped",
            Self::Busy => "the controller carries out another command",
            Self::Impossible => "the controller does not see the object, or can't read the command",
            Self::TooLate => "the controller was held up and read it too late",
            Self::WouldFall => "the object would not stand there",
            Self::OutOfReach => "the arm does not reach that far",
            Self::NotFollowing => "the arm does not go where it is told to, and stands still",
            Self::Covered => "something stands on the object",
            Self::CannotHold => "the hand can't hold an object of this size",
            Self::Clearing => "something is moved out of the way first",
            Self::ReferenceMoved => "what the object was to be beside or on was moved meanwhile",
        }
    }

    /// What a person can do about it; empty where there is nothing to be done.
    pub const fn advice(self) -> &'static str {
        match self {
            Self::Accepted | Self::Reached | Self::Clearing => "",
            Self::NoPath => "make room, and ask again",
            Self::NotGrasped => "look at the object and the gripper, and ask again",
            Self::Dropped | Self::Misplaced => "look where the object is, and ask again",
            Self::Stopped => "see that nobody is in danger, and ask again",
            Self::Busy => "wait until that one is done, or stop it",
            Self::Impossible => "see what the controller's log says",
            Self::TooLate => "see what holds it up, and ask again",
            Self::WouldFall => "ask for another place",
            Self::OutOfReach => "move the object nearer, or ask for another place",
            Self::NotFollowing => "look at the arm, and start its controller anew",
            Self::Covered => "ask for what stands on it to be moved first",
            Self::CannotHold => "ask for another object",
            Self::ReferenceMoved => "leave it where it is, and ask again",
        }
    }

    /// Whether nothing more will be said of the command.
    pub const fn is_end(self) -> bool {
        !matches!(self, Self::Accepted | Self::Clearing)
    }

    /// Whether it may go well when tried again.
    pub const fn may_be_tried_again(self) -> bool {
        matches!(
            self,
            Self::NotGrasped | Self::Dropped | Self::Misplaced | Self::ReferenceMoved
        )
    }

    /// Whether it may go well once something else stands elsewhere.
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

/// What was heard of a command, checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// Which command.
    pub id: CommandId,
    /// How it went.
    pub outcome: Outcome,
    /// Ids of objects that stood in its way, or are moved out of it; 0 for none.
    pub objects: [u32; 2],
    /// When it was so, nanoseconds on the sender's clock.
    pub timestamp_ns: u64,
}

/// Why a feedback is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FeedbackError {
    /// No outcome has this number.
    Outcome(u32),
    /// Commands count from 1.
    NoCommand,
}

impl fmt::Display for FeedbackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outcome(number) => write!(f, "feedback: {number} is no outcome"),
            Self::NoCommand => f.write_str("feedback: command 0; commands count from 1"),
        }
    }
}

impl core::error::Error for FeedbackError {}

impl Feedback {
    /// What was heard, checked.
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
    /// feedback.outcome = 99; // anything may stand in a message that was received
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
