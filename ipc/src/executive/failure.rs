use core::fmt;

use nsrm_core::{Refusal, SceneError};
use thiserror::Error;

use crate::message::Outcome;

/// Why a scene is not used.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneFault {
    /// It is invalid, or from another model or domain.
    #[error("{0}")]
    Invalid(SceneError),
    /// Its image was taken too long ago.
    #[error("the scene is {age_ms} ms old, {limit_ms} ms are allowed: does the camera work?")]
    TooOld {
        /// Its age, milliseconds.
        age_ms: u64,
        /// The greatest allowed age, milliseconds.
        limit_ms: u64,
    },
    /// Its image was taken before that of the previous scene.
    #[error("the scene is older than the previous one: is there a second publisher?")]
    OutOfOrder,
    /// Its time is in the future: its publisher has another clock.
    #[error(
        "the scene's time is {by_ms} ms in the future: synchronize its publisher's clock with the \
         planner's"
    )]
    FromTheFuture {
        /// By how much, milliseconds.
        by_ms: u64,
    },
    /// Its camera has moved, or was replaced, since the sentence was started.
    #[error(
        "the camera has moved since the sentence was started: calibrate it and send the sentence \
         again"
    )]
    OtherCamera,
}

/// Why a sentence was not executed completely. Steps count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Failure {
    /// The sentence was refused; no further object was moved.
    #[error("{0}")]
    Refused(#[source] Refusal),
    /// No usable scene arrived.
    #[error(fmt = no_scene)]
    NoScene {
        /// What was wrong with the last scene that arrived.
        last: Option<SceneFault>,
    },
    /// The controller did not accept the command and will not execute it.
    #[error(
        "step {}: the controller did not accept the command: is it running, and idle?",
        number(*.step)
    )]
    NotAccepted {
        /// Which step.
        step: u8,
    },
    /// The controller did not answer in time, or reported too late that it had started; whether
    /// the step was executed is unknown.
    #[error(
        "step {}: the controller did not answer in time, so whether the step was executed is \
         unknown; check the robot",
        number(*.step)
    )]
    Unanswered {
        /// Which step.
        step: u8,
    },
    /// The controller accepted the command and reported no outcome in time.
    #[error(
        "step {}: the controller accepted the command but reported no outcome in time; check the \
         robot",
        number(*.step)
    )]
    NoOutcome {
        /// Which step.
        step: u8,
    },
    /// The controller died or hangs; whether the step was executed is unknown.
    #[error(
        "step {}: the controller was lost, so whether the step was executed is unknown; check the \
         robot",
        number(*.step)
    )]
    ControllerLost {
        /// Which step.
        step: u8,
    },
    /// The controller reported that the command failed.
    #[error(fmt = unsuccessful)]
    Unsuccessful {
        /// Which step.
        step: u8,
        /// The reported outcome.
        outcome: Outcome,
        /// Ids of objects that the controller reported in the way; 0 for none.
        objects: [u32; 2],
    },
    /// The controller reported success, but the object or its reference is observed elsewhere.
    #[error(
        "step {}: object {object} is {:.0} mm from where it should be; check whether it was pushed \
         or fell, and send the sentence again",
        number(*.step),
        1000.0 * .off_m
    )]
    NotThere {
        /// Which step.
        step: u8,
        /// Id of that object.
        object: u32,
        /// Its distance from its sub-goal, or from where it was when the step was planned, metres.
        off_m: f32,
    },
    /// The controller reported success, but the object or its reference is not visible, and no
    /// object that a step has put down hides it.
    #[error(
        "step {}: object {object} is no longer visible; check whether it fell or is hidden, and \
         send the sentence again",
        number(*.step)
    )]
    NotSeen {
        /// Which step.
        step: u8,
        /// Id of the object.
        object: u32,
    },
    /// A description that compares or relates objects would mean another one now, after something has
    /// moved.
    #[error(
        "step {}: the description means object {found} now, and meant object {meant} when the \
         sentence was started; send it again as things stand",
        number(*.step)
    )]
    OtherObject {
        /// Which step.
        step: u8,
        /// Id of the object that was meant.
        meant: u32,
        /// Id of the object that would be meant.
        found: u32,
    },
    /// The client cancelled the sentence, or disconnected.
    #[error("cancelled")]
    Cancelled,
    /// As [`Failure::Cancelled`], but the controller did not confirm the stop.
    #[error("cancelled, but the controller did not confirm the stop; check the robot")]
    CancelledUnconfirmed,
    /// The clock was set back, so the age of scenes is unknown.
    #[error(
        "the clock was set back, so the age of scenes is unknown; check the robot, and send the \
         sentence again"
    )]
    ClockSetBack,
}

impl Failure {
    /// The variant's name in snake case; for a refusal, its kind.
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Refused(refusal) => refusal.kind(),
            Self::NoScene { .. } => "no_scene",
            Self::NotAccepted { .. } => "not_accepted",
            Self::Unanswered { .. } => "unanswered",
            Self::NoOutcome { .. } => "no_outcome",
            Self::ControllerLost { .. } => "controller_lost",
            Self::Unsuccessful { .. } => "unsuccessful",
            Self::NotThere { .. } => "not_there",
            Self::NotSeen { .. } => "not_seen",
            Self::OtherObject { .. } => "other_object",
            Self::Cancelled => "cancelled",
            Self::CancelledUnconfirmed => "cancelled_unconfirmed",
            Self::ClockSetBack => "clock_set_back",
        }
    }
}

/// What was wrong with the last scene, if any arrived.
fn no_scene(last: &Option<SceneFault>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match last {
        None => f.write_str("no scene arrived: is the perception node running?"),
        Some(fault) => write!(f, "no usable scene arrived; the last one: {fault}"),
    }
}

/// What the controller reported, what is in the way, and what to do about it.
fn unsuccessful(
    step: &u8,
    outcome: &Outcome,
    objects: &[u32; 2],
    f: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    write!(f, "step {}: {}", number(*step), outcome.words())?;
    match objects {
        [0, 0] => {}
        [object, 0] | [0, object] => write!(f, ": object {object} is in the way")?,
        [one, other] => write!(f, ": objects {one} and {other} are in the way")?,
    }
    match outcome.advice() {
        "" => Ok(()),
        advice => write!(f, "; {advice}"),
    }
}

/// The step as people count, from 1.
const fn number(step: u8) -> u32 {
    step as u32 + 1
}
