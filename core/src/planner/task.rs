use core::borrow::Borrow;
use core::task::Poll;

use super::Plan;
use super::ground::GroundingTask;
use crate::language::{Parsed, ParsingTask};
use crate::model::Model;
use crate::refusal::Refusal;
use crate::scene::Scene;

/// A plan being worked out, a bounded piece of work a [`PlanningTask::poll`]: a
/// [`ParsingTask`], then a [`GroundingTask`]. All scratch memory is in here.
///
/// `S` is the scene and `T` the sentence: borrowed, or owned where the task
/// outlives the call that began it.
#[derive(Debug, Clone)]
pub struct PlanningTask<'m, S, T> {
    parsing: ParsingTask<'m, T>,
    /// Of no steps until the sentence is parsed.
    grounding: GroundingTask<'m, S, Parsed>,
    /// Whether the sentence is parsed, or need not be.
    is_parsed: bool,
}

impl<'m, S: Borrow<Scene>, T: AsRef<str>> PlanningTask<'m, S, T> {
    pub(super) fn new(model: &'m Model<'m>, scene: S, sentence: T) -> Self {
        let grounding = GroundingTask::new(model, scene, Parsed::empty(model), 0);
        Self {
            parsing: ParsingTask::new(model, sentence),
            // In a scene of another model no sentence can be obeyed.
            is_parsed: grounding.is_refused(),
            grounding,
        }
    }

    /// Does one piece of work, at most [`super::UNIT_MULTIPLY_ADDS`]. Once it is
    /// done, every further call gives the same result again.
    pub fn poll(&mut self) -> Poll<Result<Plan, Refusal>> {
        if self.is_parsed {
            return self.grounding.poll();
        }
        match self.parsing.poll() {
            Poll::Pending => Poll::Pending,
            Poll::Ready(Err(refusal)) => Poll::Ready(Err(refusal)),
            Poll::Ready(Ok(parsed)) => {
                self.grounding.begin(parsed.clone());
                self.is_parsed = true;
                Poll::Pending
            }
        }
    }
}
