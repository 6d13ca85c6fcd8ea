use core::fmt;

use nsrm_core::{Refusal, SceneError};

use crate::message::Outcome;

/// Why a scene is not acted upon.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SceneFault {
    /// It is no scene, or of another model or domain.
    Invalid(SceneError),
    /// Its image was taken too long ago.
    TooOld {
        /// How long, milliseconds.
        age_ms: u64,
        /// The most that is allowed, milliseconds.
        limit_ms: u64,
    },
    /// Its image was taken before that of the scene that came before it.
    OutOfOrder,
    /// Its image is yet to be taken: its publisher has another clock.
    FromTheFuture {
        /// By how much, milliseconds.
        by_ms: u64,
    },
    /// Its camera stands elsewhere, or is another one, than when the sentence was
    /// begun.
    OtherCamera,
}

impl fmt::Display for SceneFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid(error) => write!(f, "{error}"),
            Self::TooOld { age_ms, limit_ms } => write!(
                f,
                "the scene is {age_ms} ms old, {limit_ms} ms are allowed: does the camera work?"
            ),
            Self::OutOfOrder => f.write_str(
                "the scene is older than the one before it: is there a second publisher?",
            ),
            Self::FromTheFuture { by_ms } => write!(
                f,
                "the scene was seen {by_ms} ms in the future: set its publisher's clock by the \
                 planner's"
            ),
            Self::OtherCamera => f.write_str(
                "the camera has moved since the sentence was begun: calibrate it and ask again",
            ),
        }
    }
}

impl core::error::Error for SceneFault {}

/// Why a sentence was not carried out, or not to its end. Steps count from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Failure {
    /// It is refused; nothing, or nothing more, was moved.
    Refused(Refusal),
    /// No scene came that may be acted upon.
    NoScene {
        /// Why the last one that came was not.
        last: Option<SceneFault>,
    },
    /// The controller did not accept the command, and will not carry it out.
    NotAccepted {
        /// Which step.
        step: u8,
    },
    /// Nothing was heard of the controller in time, or too late that it had begun; whether the
    /// step was carried out is unknown.
    Unanswered {
        /// Which step.
        step: u8,
    },
    /// The controller accepted the command, and nothing was heard of it in time.
    NoOutcome {
        /// Which step.
        step: u8,
    },
    /// The controller died or hangs; whether the step was carried out is unknown.
    ControllerLost {
        /// Which step.
        step: u8,
    },
    /// The controller says that it could not do it.
    Unsuccessful {
        /// Which step.
        step: u8,
        /// What it says.
        outcome: Outcome,
        /// Ids of objects that stood in the way, as it says; 0 for none.
        objects: [u32; 2],
    },
    /// The controller says that it did it, and the object, or what it was to be beside
    /// or on, is seen elsewhere.
    NotThere {
        /// Which step.
        step: u8,
        /// Id of the object that is.
        object: u32,
        /// How far from its sub-goal, or from where it was when the step was planned, metres.
        off_m: f32,
    },
    /// The controller says that it did it, and the object, or what it was to be beside or on, is
    /// not seen, and nothing hides it that a step has put down.
    NotSeen {
        /// Which step.
        step: u8,
        /// Id of the object.
        object: u32,
    },
    /// The one who asked doesn't want it any more, or is gone.
    Cancelled,
    /// As before, but the controller did not say that it has stopped.
    CancelledUnconfirmed,
    /// The clock was set back, so that nobody can tell how old a scene is.
    ClockSetBack,
}

impl Failure {
    /// The variant's name in snake case, a refusal's with its kind.
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
            Self::Cancelled => "cancelled",
            Self::CancelledUnconfirmed => "cancelled_unconfirmed",
            Self::ClockSetBack => "clock_set_back",
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // People count from 1.
        let step = |step: u8| u32::from(step) + 1;
        match self {
            Self::Refused(refusal) => write!(f, "{refusal}"),
            Self::NoScene { last: None } => {
                f.write_str("no scene came: is the perception node running?")
            }
            Self::NoScene { last: Some(fault) } => {
                write!(
                    f,
                    "no scene came that may be acted upon; the last one: {fault}"
                )
            }
            Self::NotAccepted { step: at } => write!(
                f,
                "step {}: the controller did not accept it: is it running, and free?",
                step(*at)
            ),
            Self::Unanswered { step: at } => write!(
                f,
                "step {}: the controller did not answer in time, so whether it was carried out is \
                 unknown; look at the robot",
                step(*at)
            ),
            Self::NoOutcome { step: at } => write!(
                f,
                "step {}: the controller accepted it and did not say in time how it went; look \
                 at the robot",
                step(*at)
            ),
            Self::ControllerLost { step: at } => write!(
                f,
                "step {}: the controller was lost, so whether it was carried out is unknown; \
                 look at the robot",
                step(*at)
            ),
            Self::Unsuccessful {
                step: at,
                outcome,
                objects,
            } => {
                write!(f, "step {}: {}", step(*at), outcome.words())?;
                match objects {
                    [0, 0] => {}
                    [object, 0] | [0, object] => write!(f, ": object {object} is in the way")?,
                    [one, other] => {
                        write!(f, ": objects {one} and {other} are in the way")?;
                    }
                }
                match outcome.advice() {
                    "" => Ok(()),
                    advice => write!(f, "; {advice}"),
                }
            }
            Self::NotThere {
                step: at,
                object,
                off_m,
            } => write!(
                f,
                "step {}: object {object} is seen {:.0} mm from where it should be; see whether \
                 it was pushed or fell, and ask again",
                step(*at),
                1000.0 * off_m
            ),
            Self::NotSeen { step: at, object } => {
                write!(
                    f,
                    "step {}: object {object} is no longer seen; see whether it fell or is hidden, \
                     and ask again",
                    step(*at)
                )
            }
            Self::Cancelled => f.write_str("cancelled"),
            Self::CancelledUnconfirmed => f.write_str(
                "cancelled, but the controller did not say that it has stopped; look at the robot",
            ),
            Self::ClockSetBack => f.write_str(
                "the clock was set back meanwhile, so how old a scene is can't be told; look at \
                 the robot, and ask again",
            ),
        }
    }
}

impl core::error::Error for Failure {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Refused(refusal) => Some(refusal),
            _ => None,
        }
    }
}
