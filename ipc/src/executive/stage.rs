//! What a sentence on its way waits for.

use nsrm_core::language::{Parsed, ParsingTask};
use nsrm_core::planner::GroundingTask;
use nsrm_core::scene::Scene;

use super::failure::Failure;
use super::placed::Undone;
use super::{Command, CommandId, Sentence};
use crate::message::Report;

/// What comes next.
#[derive(Debug)]
// A job has one stage, and there is one job.
#[allow(clippy::large_enum_variant)]
pub(super) enum Stage<'m> {
    Parse(ParsingTask<'m, Sentence>),
    /// A scene seen later than this is waited for.
    Look {
        after_ns: u64,
        since_ns: u64,
        purpose: Purpose,
    },
    Ground {
        task: GroundingTask<'m, Scene, Parsed>,
        taken_ns: u64,
        since_ns: u64,
    },
    /// The next step of the plan is commanded.
    Send {
        /// When the scene was seen in which it was grounded, and since when one is waited for;
        /// nobody looks with the loop open.
        seen: Option<(u64, u64)>,
    },
    /// Its outcome is waited for.
    Commanded {
        command: Command,
        sent_ns: u64,
        /// When it was sent, or accepted.
        since_ns: u64,
        heard: CommandStatus,
    },
    /// A stop was sent; then the sentence ends so.
    Stopping {
        id: CommandId,
        since_ns: u64,
        /// Whether the controller was lost: one that was held up must not begin, or go on, with
        /// what has been given up; but its answer is not waited for.
        is_lost: bool,
        confirmed: bool,
        /// Whether it is known meanwhile that it was begun.
        begun: bool,
        why: Failure,
    },
    Finished,
}

/// What a scene is waited for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Purpose {
    /// To ground the step that is next; in the scenes so far it may have been refused.
    Ground { refused: Option<Failure> },
    /// To see what has become of a step, and whether those before it are still as they should be.
    Verify {
        tried: Tried,
        /// What is no longer observed in the scenes so far.
        missing: Option<Undone>,
    },
}

/// What the controller said of the step that was tried last.
#[derive(Debug, Clone, Copy)]
pub(super) enum Tried {
    /// It was done, which is yet to be confirmed.
    Reached,
    /// It could not be done as things stood.
    Unable(Failure),
    /// What came of it is known.
    Known,
}

/// What was heard of a command.
#[derive(Debug, Clone, Copy)]
pub(super) enum CommandStatus {
    Nothing,
    Accepted,
    Ended(Report),
    /// No more of it: the controller died.
    Lost,
    /// It could not be sent.
    Undelivered,
}
