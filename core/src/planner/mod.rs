//! The public interface: plans a sentence in a scene, at once or in bounded units of work.
//!
//! A plan is the grounded program `P_g` and the sub-goals
//! `G = [(o_1, p_1), …]` of section IV-D, with every probability and cosine that
//! led to it.

mod distance;
mod ground;
mod plan;
mod resolve;
mod room;
mod sight;
mod superlative;
mod task;
#[cfg(test)]
mod tests;

pub use ground::GroundingTask;
pub use plan::{Confidence, Grounding, Plan, PlannedStep, SubGoal};
pub use task::PlanningTask;

use core::borrow::Borrow;
use core::mem::size_of;
use core::task::Poll;

use crate::calibration::{self, Cause};
use crate::capacity::{
    MAX_FILTERS, MAX_GROUPS, MAX_OBJECTS, MAX_READINGS, MAX_RELATIONS, MAX_SPLITS, MAX_STEPS,
    MAX_TOKENS,
};
use crate::language::{Parsed, ParsingTask, SUPERLATIVES};
use crate::model::{
    ACCEPTABILITY_HIDDEN, COMPOSED, CONCEPT, ENCODER_HIDDEN, HAZARD_INPUT, INSTRUCTION, LOCATION,
    MAX_SIDES, Model, OPERATOR_HIDDEN, SIMULATOR_HIDDEN, SPLITTER_HIDDEN, SPLITTER_WORD,
    VIEW_EMBEDDING, WORD,
};
use crate::refusal::Refusal;
use crate::scene::Scene;

/// Scratch memory of planning, including the plan; all of it is in the task, which here borrows
/// scene and sentence.
pub const TASK_BYTES: usize = size_of::<PlanningTask<'_, &Scene, &str>>();
/// Memory of a plan.
pub const PLAN_BYTES: usize = size_of::<Plan>();
/// Memory of a scene.
pub const SCENE_BYTES: usize = size_of::<Scene>();

// What callers set aside for a task and a plan, and what a refusal costs to pass on.
const _: () = assert!(TASK_BYTES <= 15 * 1024 + 512 && PLAN_BYTES <= 2112);
const _: () = assert!(size_of::<Refusal>() <= 104);

/// The most multiply-adds of one [`PlanningTask::poll`] on a model of up to [`UNIT_ACTIONS`]
/// actions. Besides these, a call takes at most 192 scalar functions, or one pass over a word.
pub const UNIT_MULTIPLY_ADDS: usize = {
    let units = [
        // One token through the splitter.
        (3 * (SPLITTER_WORD + SPLITTER_HIDDEN) + HAZARD_INPUT + 1) * SPLITTER_HIDDEN,
        // One token through one direction of the encoder, and its acceptability.
        3 * (WORD + ENCODER_HIDDEN) * ENCODER_HIDDEN + (ENCODER_HIDDEN + 1) * ACCEPTABILITY_HIDDEN,
        // One argument decoder.
        (INSTRUCTION + MAX_GROUPS) * INSTRUCTION,
        // One object's score: filters, with all values of their types, its volume, a relation by up to two
        // actions with its three places and their angle, and how it is seen, with the places of all objects twice.
        MAX_FILTERS * ((VIEW_EMBEDDING + CONCEPT) * OPERATOR_HIDDEN + 2 * CONCEPT)
            + (VIEW_EMBEDDING + CONCEPT) * OPERATOR_HIDDEN
            + (MAX_FILTERS + 1) * (UNIT_VALUES + 1) * (CONCEPT + 3)
            + COMPOSED * (3 * LOCATION + SIMULATOR_HIDDEN) * SIMULATOR_HIDDEN
            + 3 * (3 * (LOCATION + 1) + 3)
            + 2 * MAX_OBJECTS * (2 * 3 * (LOCATION + 1) + 4 * 9 + 16),
        // Superlatives, of a relation and an extreme: for each an action, and the place of each object
        // and of the anchor, with their distance or how far it lies in a direction.
        2 * (MAX_OBJECTS * (2 * 3 * (LOCATION + 1) + 12)
            + (3 * LOCATION + SIMULATOR_HIDDEN) * SIMULATOR_HIDDEN),
        // One action, or a compound of them.
        COMPOSED * (3 * LOCATION + SIMULATOR_HIDDEN) * SIMULATOR_HIDDEN,
        // All objects' places, each compared with all others and with all sizes.
        MAX_OBJECTS * (3 * (LOCATION + 1) + 2 * 9 + 4 * MAX_OBJECTS + 4 * UNIT_VALUES),
    ];
    // One group's role: two for each relation, of actions and superlatives.
    let mut most = 2 * (UNIT_ACTIONS + SUPERLATIVES) * INSTRUCTION;
    let mut rest = units.as_slice();
    while let [unit, behind @ ..] = rest {
        most = if *unit > most { *unit } else { most };
        rest = behind;
    }
    most
};
/// Actions up to which [`UNIT_MULTIPLY_ADDS`] holds; the action decoder takes 96
/// multiply-adds for each, the relation decoder 192, and as much for each superlative.
pub const UNIT_ACTIONS: usize = 64;

/// Values of an attribute type, such as sizes, up to which [`UNIT_MULTIPLY_ADDS`] holds.
pub const UNIT_VALUES: usize = 64;

/// The most calls of [`PlanningTask::poll`] until it is done: for each reading of the sentence
/// words and what is rewritten, and for each way to split it tokens through splitter and encoder, and for each step its
/// begin, three decoders and the role of each group; the scene against the calibration, which takes another for each cause that
/// may explain what disagrees; and for each step two descriptions, each with all that it relates to
/// over all objects and a choice, or each place on the table, and the action, twice if it moves several
/// objects.
pub const MAX_POLLS: usize = MAX_READINGS * MAX_SPLITS * READING_POLLS
    + Cause::ALL.len()
    + 2 * MAX_STEPS * GROUNDING_POLLS
    + 3;
const READING_POLLS: usize = (MAX_FILTERS + 14) * MAX_TOKENS + 6 + MAX_STEPS * (5 + MAX_GROUPS);
const GROUNDING_POLLS: usize =
    2 * (1 + MAX_RELATIONS) * (MAX_OBJECTS + 1) + MAX_SIDES * MAX_OBJECTS + 1 + 1 + 1;

/// Plans with one model. Holds only a reference to the model.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::Planner;
/// use nsrm_tabletop::TABLETOP;
///
/// # let scene = scene(&TABLETOP);
/// let planner = Planner::new(&TABLETOP);
/// let plan = planner.plan(&scene, "put the red block on the small yellow block")?;
/// println!("{}", plan.program().notation(&TABLETOP));
/// for goal in plan.sub_goals() {
///     println!("object {} to {}", goal.object, goal.pose);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Planner<'m> {
    model: &'m Model<'m>,
}

impl<'m> Planner<'m> {
    /// A planner for a model that has passed [`Model::check`], as all models of the code generator
    /// and the loader have.
    pub const fn new(model: &'m Model<'m>) -> Self {
        Self { model }
    }

    /// The model.
    pub const fn model(&self) -> &'m Model<'m> {
        self.model
    }

    /// The program of a sentence, independent of a scene: [`ParsingTask`] polled to its end.
    ///
    /// ```
    /// use nsrm_core::{Planner, Refusal};
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// let planner = Planner::new(&TABLETOP);
    /// let parsed = planner.parse("put the red block on the small blue block")?;
    /// assert_eq!(parsed.program().steps().len(), 1);
    /// let refused = planner.parse("fly to the moon").unwrap_err();
    /// assert!(matches!(refused, Refusal::UnknownWord { .. }));
    /// # Ok::<(), Refusal>(())
    /// ```
    pub fn parse(&self, sentence: &str) -> Result<Parsed, Refusal> {
        let mut task = ParsingTask::new(self.model, sentence);
        loop {
            if let Poll::Ready(parsed) = task.poll() {
                return parsed.cloned();
            }
        }
    }

    /// Checks that a scene agrees with the camera's calibration, as planning does first; use it
    /// when a camera is set up.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use nsrm_core::{Planner, Refusal, Scene};
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # let scene = scene(&TABLETOP);
    /// let planner = Planner::new(&TABLETOP);
    /// assert_eq!(planner.check(&scene), Ok(()));
    ///
    /// // As if the camera hung 5 cm higher than it does.
    /// let mut raw = *scene.raw();
    /// raw.camera.position[2] += 0.05;
    /// let scene = Scene::new(raw, &TABLETOP)?;
    /// assert!(matches!(planner.check(&scene), Err(Refusal::Calibration(_))));
    /// # Ok(())
    /// # }
    /// ```
    pub fn check(&self, scene: &Scene) -> Result<(), Refusal> {
        ground::check_model(self.model, scene)?;
        calibration::check(self.model, scene).map_err(Refusal::Calibration)
    }

    /// A plan for a sentence in a scene: [`Planner::begin`] polled to its end.
    ///
    /// Cost: at most [`MAX_POLLS`] times [`UNIT_MULTIPLY_ADDS`]; a one-step
    /// sentence of ten words takes about 0.25 million multiply-adds.
    /// Stack: [`TASK_BYTES`], [`PLAN_BYTES`] and about 5 KiB.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use nsrm_core::{Planner, Refusal};
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # let scene = scene(&TABLETOP); // objects 1 to 4: green, magenta, yellow, red; all but 2 small
    /// let planner = Planner::new(&TABLETOP);
    /// let plan = planner.plan(&scene, "put the red block on the lego block")?;
    /// let goal = plan.sub_goals().next().expect("one step");
    /// assert_eq!(goal.object, 4);
    /// assert!(goal.pose.translation.z > 0.05); // metres above the table
    ///
    /// let refused = planner.plan(&scene, "put the small block on the lego block").unwrap_err();
    /// let Refusal::Ambiguous { candidates, .. } = refused else {
    ///     panic!("{refused}");
    /// };
    /// assert_eq!(candidates.count(), 3);
    /// # Ok(())
    /// # }
    /// ```
    pub fn plan(&self, scene: &Scene, sentence: &str) -> Result<Plan, Refusal> {
        let mut task = self.begin(scene, sentence);
        loop {
            if let Poll::Ready(plan) = task.poll() {
                return plan.cloned();
            }
        }
    }

    /// Starts a plan that is computed call by call, so that a control loop can spread it over its
    /// ticks.
    ///
    /// ```
    /// use core::task::Poll;
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use nsrm_core::Planner;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # let scene = scene(&TABLETOP);
    /// let planner = Planner::new(&TABLETOP);
    /// let mut task = planner.begin(&scene, "put the red block on the yellow block");
    /// let plan = loop {
    ///     match task.poll() {
    ///         // At most UNIT_MULTIPLY_ADDS were done: wait for the next tick.
    ///         Poll::Pending => {}
    ///         Poll::Ready(result) => break result?,
    ///     }
    /// };
    /// assert_eq!(plan.steps().len(), 1);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// A task that must outlive scene and sentence owns them:
    ///
    /// ```
    /// # use nsrm_core::{MAX_SENTENCE_BYTES, PlanningTask, Scene, model::Model};
    /// # use heapless::String;
    /// struct Loop<'m> {
    ///     task: Option<PlanningTask<'m, Scene, String<MAX_SENTENCE_BYTES>>>,
    /// }
    /// ```
    pub fn begin<S, T>(&self, scene: S, sentence: T) -> PlanningTask<'m, S, T>
    where
        S: Borrow<Scene>,
        T: AsRef<str>,
    {
        PlanningTask::new(self.model, scene, sentence)
    }

    /// Starts to ground a parsed sentence in a scene, from step `first` on (from 0): a plan for the
    /// remaining steps in the current scene. Refusals count steps as in the whole sentence. A
    /// sentence parsed by another model is refused.
    ///
    /// ```
    /// use core::task::Poll;
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use nsrm_core::Planner;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # let scene = scene(&TABLETOP);
    /// let planner = Planner::new(&TABLETOP);
    /// let sentence = "put the red block on the lego block, then put the green block on the red block";
    /// let parsed = planner.parse(sentence)?;
    /// // The first step is done, and this is what was observed then.
    /// let mut task = planner.begin_grounding(&scene, &parsed, 1);
    /// let plan = loop {
    ///     if let Poll::Ready(result) = task.poll() {
    ///         break result?;
    ///     }
    /// };
    /// assert_eq!((plan.first(), plan.steps().len()), (1, 1));
    /// # Ok(())
    /// # }
    /// ```
    pub fn begin_grounding<S: Borrow<Scene>>(
        &self,
        scene: S,
        parsed: &Parsed,
        first: usize,
    ) -> GroundingTask<'m, S> {
        GroundingTask::new(self.model, scene, parsed.clone(), first)
    }
}
