//! The stages of a running sentence.

use nsrm_core::language::ParsingTask;
use nsrm_core::planner::GroundingTask;
use nsrm_core::scene::Scene;

use super::failure::Failure;
use super::placed::Undone;
use super::{Command, CommandId, Sentence};
use crate::message::Report;

/// The current stage.
#[derive(Debug)]
// A job has one stage, and there is one job.
#[allow(clippy::large_enum_variant)]
pub(super) enum Stage<'m> {
    Parse(ParsingTask<'m, Sentence>),
    /// Waits for a scene later than this.
    Look {
        after_ns: u64,
        since_ns: u64,
        purpose: Purpose,
    },
    Ground {
        task: GroundingTask<'m, Scene>,
        taken_ns: u64,
        since_ns: u64,
    },
    /// Sends the command of the next step.
    Send {
        /// The time of the scene in which it was grounded, and since when it waited for one; `None`
        /// in open loop.
        seen: Option<(u64, u64)>,
    },
    /// Waits for the outcome of a command.
    Commanded {
        command: Command,
        sent_ns: u64,
        /// When it was sent, or accepted.
        since_ns: u64,
        heard: CommandStatus,
    },
    /// A stop was sent; waits for its confirmation, then ends the sentence.
    Stopping {
        id: CommandId,
        since_ns: u64,
        /// Whether the controller was lost. A stop is sent in case it was only delayed, but its
        /// answer is not awaited.
        is_lost: bool,
        confirmed: bool,
        /// Whether the command is known to have started.
        begun: bool,
        why: Failure,
    },
    Finished,
}

/// What a scene is needed for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Purpose {
    /// To ground the next step; it may have been refused in earlier scenes.
    Ground { refused: Option<Failure> },
    /// To verify a step and those before it.
    Verify {
        tried: Tried,
        /// Objects that were missing in the scenes so far.
        missing: Option<Undone>,
    },
}

/// What the controller reported about the last attempt.
#[derive(Debug, Clone, Copy)]
pub(super) enum Tried {
    /// It was done, which an observation must confirm.
    Reached,
    /// It was impossible in the state of the scene.
    Unable(Failure),
    /// Its result is known.
    Known,
}

/// What is known about a command.
#[derive(Debug, Clone, Copy)]
pub(super) enum CommandStatus {
    Nothing,
    Accepted,
    Ended(Report),
    /// Nothing more: the controller was lost.
    Lost,
    /// It could not be delivered.
    Undelivered,
}
