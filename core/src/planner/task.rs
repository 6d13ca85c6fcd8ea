use core::borrow::Borrow;
use core::task::Poll;

use super::Plan;
use super::ground::GroundingTask;
use crate::language::{Parsed, ParsingTask};
use crate::model::Model;
use crate::refusal::Refusal;
use crate::scene::Scene;

/// A plan in progress; each [`PlanningTask::poll`] does a bounded unit of work: a [`ParsingTask`],
/// then a [`GroundingTask`]. All scratch memory is in here.
///
/// `S` is the scene and `T` the sentence: borrowed, or owned where the task
/// outlives the call that began it.
#[derive(Debug, Clone)]
pub struct PlanningTask<'m, S, T> {
    parsing: ParsingTask<'m, T>,
    /// Without steps until the sentence is parsed.
    grounding: GroundingTask<'m, S>,
    /// Whether the sentence is parsed, or the scene was refused before parsing.
    is_parsed: bool,
}

impl<'m, S: Borrow<Scene>, T: AsRef<str>> PlanningTask<'m, S, T> {
    pub(super) fn new(model: &'m Model<'m>, scene: S, sentence: T) -> Self {
        let grounding = GroundingTask::new(model, scene, Parsed::empty(model), 0);
        Self {
            parsing: ParsingTask::new(model, sentence),
            // A scene of another model is refused whatever the sentence.
            is_parsed: grounding.is_refused(),
            grounding,
        }
    }

    /// What the sentence says; `None` until it is parsed, and if it or the scene was refused before.
    pub fn parsed(&self) -> Option<&Parsed> {
        let parsed = self.grounding.parsed();
        (!parsed.decisions().is_empty()).then_some(parsed)
    }

    /// Does one unit of work, at most [`super::UNIT_MULTIPLY_ADDS`]. Once it is done, every further
    /// call returns the same result. The plan is the task's own; clone it to keep it longer.
    pub fn poll(&mut self) -> Poll<Result<&Plan, Refusal>> {
        if self.is_parsed {
            return self.grounding.poll();
        }
        match self.parsing.poll() {
            Poll::Pending => Poll::Pending,
            Poll::Ready(Err(refusal)) => Poll::Ready(Err(refusal)),
            Poll::Ready(Ok(parsed)) => {
                self.grounding.begin(parsed);
                self.is_parsed = true;
                Poll::Pending
            }
        }
    }
}
