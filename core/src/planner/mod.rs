//! The public face: a sentence and a scene to a plan, at once or in bounded
//! pieces.
//!
//! A plan is the grounded program `P_g` and the sub-goals
//! `G = [(o_1, p_1), …]` of section IV-D, with every probability and cosine that
//! led to it.

mod plan;
mod task;
#[cfg(test)]
mod tests;

pub use plan::{Confidence, Grounding, Plan, PlannedStep, SubGoal};
pub use task::PlanningTask;

use core::mem::size_of;

use crate::capacity::{MAX_FILTERS, MAX_GROUPS, MAX_OBJECTS, MAX_STEPS, MAX_TOKENS};
use crate::dsl::Program;
use crate::language::ParsingTask;
use crate::model::{
    CONCEPT, ENCODER_HIDDEN, INSTRUCTION, LOCATION, Model, OPERATOR_HIDDEN, SIMULATOR_HIDDEN,
    SPLITTER_HIDDEN, VIEW_EMBEDDING,
};
use crate::progress::Progress;
use crate::refusal::Refusal;
use crate::scene::Scene;

/// Scratch memory of planning, the plan included; all of it is in the task.
pub const TASK_BYTES: usize = size_of::<PlanningTask<'_>>();
/// Memory of a plan.
pub const PLAN_BYTES: usize = size_of::<Plan>();
/// Memory of a scene.
pub const SCENE_BYTES: usize = size_of::<Scene>();

// What callers set aside for a task and a plan, and what a refusal costs to pass on.
const _: () = assert!(TASK_BYTES <= 10 * 1024 && PLAN_BYTES <= 1024);
const _: () = assert!(size_of::<Refusal>() <= 96);

/// The most multiply-adds of one [`PlanningTask::poll`] on a model of up to
/// [`UNIT_ACTIONS`] actions. Beside them a call takes at most 192 scalar
/// functions, or one pass over a word.
pub const UNIT_MULTIPLY_ADDS: usize = {
    let units = [
        // One token through the splitter.
        4 * SPLITTER_HIDDEN * SPLITTER_HIDDEN + SPLITTER_HIDDEN,
        // One token through one direction of the encoder.
        3 * ENCODER_HIDDEN * ENCODER_HIDDEN,
        // One argument decoder.
        (INSTRUCTION + MAX_GROUPS) * INSTRUCTION,
        // One object's score.
        MAX_FILTERS * ((VIEW_EMBEDDING + CONCEPT) * OPERATOR_HIDDEN + 2 * CONCEPT),
        // One action.
        (3 * LOCATION + SIMULATOR_HIDDEN) * SIMULATOR_HIDDEN,
    ];
    let mut most = UNIT_ACTIONS * INSTRUCTION;
    let mut rest = units.as_slice();
    while let [unit, behind @ ..] = rest {
        most = if *unit > most { *unit } else { most };
        rest = behind;
    }
    most
};
/// Actions up to which [`UNIT_MULTIPLY_ADDS`] holds; the action decoder takes 96
/// multiply-adds for each.
pub const UNIT_ACTIONS: usize = 64;

/// The most calls of [`PlanningTask::poll`] until it is done: words, tokens
/// through splitter and encoder, and for each step its begin, three decoders,
/// two descriptions over all objects, two choices and the action.
pub const MAX_POLLS: usize = (MAX_FILTERS + 3) * MAX_TOKENS + MAX_STEPS * (2 * MAX_OBJECTS + 7) + 3;

/// Reads sentences and scenes with one model. Holds nothing but the model.
///
/// ```
/// use nsrm_core::{Planner, Scene, model::Model};
///
/// fn tell(model: &Model<'_>, scene: &Scene) -> Result<(), nsrm_core::Refusal> {
///     let planner = Planner::new(model);
///     let plan = planner.plan(scene, "put the red block on the small blue block")?;
///     println!("{}", plan.program().notation(model));
///     for goal in plan.sub_goals() {
///         println!("object {} to {}", goal.object, goal.pose);
///     }
///     Ok(())
/// }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Planner<'m> {
    model: &'m Model<'m>,
}

impl<'m> Planner<'m> {
    /// A planner on a model that passed [`Model::check`], as all that the code
    /// generator and the loader make have.
    pub const fn new(model: &'m Model<'m>) -> Self {
        Self { model }
    }

    /// The model.
    pub const fn model(&self) -> &'m Model<'m> {
        self.model
    }

    /// What a sentence says is to be done, whatever the scene.
    pub fn parse(&self, sentence: &str) -> Result<Program, Refusal> {
        let mut task = ParsingTask::new(self.model, sentence);
        loop {
            if let Progress::Done(parsed) = task.poll() {
                return parsed.map(|parsed| parsed.program.clone());
            }
        }
    }

    /// A plan for a sentence in a scene: [`Planner::begin`] polled to its end.
    ///
    /// Cost: at most [`MAX_POLLS`] times [`UNIT_MULTIPLY_ADDS`]; a one-step
    /// sentence of ten words takes about 0.25 million multiply-adds.
    /// Stack: [`TASK_BYTES`], [`PLAN_BYTES`] and about 5 KiB.
    pub fn plan(&self, scene: &Scene, sentence: &str) -> Result<Plan, Refusal> {
        let mut task = self.begin(scene, sentence);
        loop {
            if let Progress::Done(plan) = task.poll() {
                return plan;
            }
        }
    }

    /// Begins a plan that is worked out call by call, so that a control loop may
    /// spread it over its ticks.
    ///
    /// ```
    /// # fn tick(planner: &nsrm_core::Planner<'_>, scene: &nsrm_core::Scene) {
    /// use nsrm_core::Progress;
    /// let mut task = planner.begin(scene, "put the red block on the blue block");
    /// while let Progress::Pending = task.poll() {
    ///     // at most UNIT_MULTIPLY_ADDS: wait for the next tick
    /// }
    /// # }
    /// ```
    pub fn begin<'a>(&self, scene: &'a Scene, sentence: &'a str) -> PlanningTask<'a>
    where
        'm: 'a,
    {
        PlanningTask::new(self.model, scene, sentence)
    }
}
