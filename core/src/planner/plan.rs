use heapless::Vec;
use nalgebra::Isometry3;

use crate::capacity::{MAX_RELATIONS, MAX_STEPS};
use crate::dsl::{Program, Step};
use crate::grounding::Chosen;
use crate::language::{Correction, Parsed};
use crate::model::{LOCATION, Model};

/// A sub-goal, where to move an object: the paper's `(o_t, p_t)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SubGoal {
    /// Id of the object.
    pub object: u32,
    /// Pose of its centre: world frame, metres.
    pub pose: Isometry3<f32>,
}

/// The object that a description refers to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Grounding {
    /// Id of the object.
    pub object: u32,
    /// Its place in the scene.
    pub index: u8,
    /// How well it fits: the smallest cosine of the description's concepts and of its relation.
    pub score: f32,
    /// Its share in the softmax of `Unique`; with relations, those of all `Unique`s of the chain
    /// multiplied.
    pub probability: f32,
    /// Ids of the anchors, then zeros.
    anchors: [u32; MAX_RELATIONS],
    anchor_count: u8,
}

impl Grounding {
    /// Without relations.
    ///
    /// * `index`: the object's place in the scene
    pub(super) const fn new(object: u32, index: u8, chosen: &Chosen) -> Self {
        Self {
            object,
            index,
            score: chosen.score,
            probability: chosen.probability,
            anchors: [0; MAX_RELATIONS],
            anchor_count: 0,
        }
    }

    /// The same object as the one that is in a relation to `anchor`.
    pub(super) fn related_to(self, anchor: &Self) -> Self {
        let mut related = Self {
            probability: self.probability * anchor.probability,
            ..self
        };
        let ids = core::iter::once(anchor.object).chain(anchor.anchors().iter().copied());
        for (place, id) in related.anchors.iter_mut().zip(ids) {
            *place = id;
            related.anchor_count += 1;
        }
        related
    }

    /// Ids of the objects that the description relates it to, from the object's own relation to
    /// that of the innermost anchor.
    pub fn anchors(&self) -> &[u32] {
        self.anchors
            .get(..usize::from(self.anchor_count))
            .unwrap_or_default()
    }
}

/// The confidence of a step, part by part; probabilities.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Confidence {
    /// That the step ends where the sentence was split.
    pub split: f32,
    /// That all words of the step stand where commands have them.
    pub words: f32,
    /// That the action is right.
    pub action: f32,
    /// That the words' relations to each other are right.
    pub relations: f32,
    /// That these words describe the object to move.
    pub object: f32,
    /// That these words describe the reference.
    pub reference: f32,
    /// That the description, with all that it relates to, refers to this object.
    pub object_unique: f32,
    /// That the description, with all that it relates to, refers to this reference.
    pub reference_unique: f32,
}

impl Confidence {
    /// The probability that every choice of the step is right, each given those
    /// before it: all parts multiplied.
    pub fn joint(&self) -> f32 {
        self.split
            * self.words
            * self.action
            * self.relations
            * self.object
            * self.reference
            * self.object_unique
            * self.reference_unique
    }
}

/// A step of a plan: its objects, where the moved one will be, and the confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PlannedStep {
    /// Index into [`crate::Model::actions`]; behind these, that of a compound of two actions. For the table, and
    /// for a compound of any of some actions, the one that gives the place there.
    pub action: u8,
    /// The object that is moved.
    pub object: Grounding,
    /// The reference object. For the table, the object that the place is beside.
    pub reference: Grounding,
    /// Where the moved object will be observed: box corners x1, y1, x2, y2 as fractions of the
    /// image, mean depth in metres. May lie outside the image.
    pub location: [f32; LOCATION],
    /// Its pose in the world.
    pub sub_goal: SubGoal,
    /// The step's confidence.
    pub confidence: Confidence,
}

/// A plan in a scene; at most [`MAX_STEPS`] steps.
// Invariant: a planned step for each step of the program from `first` on, in the
// same order.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    parsed: Parsed,
    first: u8,
    steps: Vec<PlannedStep, MAX_STEPS, u8>,
}

impl Plan {
    /// The program: the parsed one, in which each step that moves several objects is replaced by one
    /// for each.
    pub const fn program(&self) -> &Program {
        self.parsed.program()
    }

    /// That program with the parser's confidence: what the rest of the plan is grounded from again, with
    /// the same objects where several are moved.
    pub const fn parsed(&self) -> &Parsed {
        &self.parsed
    }

    /// Misspelt words of the sentence, and what they were read as: tell the person.
    pub fn corrections(&self) -> &[Correction] {
        self.parsed.corrections()
    }

    /// The step of the program at which [`Plan::steps`] starts, from 0: 0 unless only the rest of a
    /// program was grounded.
    pub const fn first(&self) -> usize {
        self.first as usize
    }

    /// The steps, in the order of execution; one for each step of the program from [`Plan::first`]
    /// on.
    pub fn steps(&self) -> &[PlannedStep] {
        &self.steps
    }

    /// The planned steps, each with its number in the program, from 0, and its parsed step. If only
    /// the rest of a program was grounded, the first number is [`Plan::first`].
    pub fn numbered(&self) -> impl Iterator<Item = (usize, &Step, &PlannedStep)> {
        let understood = self.program().steps().iter().enumerate().skip(self.first());
        understood
            .zip(&self.steps)
            .map(|((number, understood), planned)| (number, understood, planned))
    }

    /// The probability that every choice of the plan is right, as far as the model can tell:
    /// [`Confidence::joint`] of all steps multiplied. It says nothing about anything that was not a
    /// choice, such as a sentence on another subject.
    pub fn confidence(&self) -> f32 {
        self.steps
            .iter()
            .map(|step| step.confidence.joint())
            .product()
    }

    /// The sub-goals for a motion planner, in order.
    pub fn sub_goals(&self) -> impl ExactSizeIterator<Item = &SubGoal> {
        self.steps.iter().map(|step| &step.sub_goal)
    }

    /// No steps yet.
    pub(super) const fn new(parsed: Parsed, first: u8) -> Self {
        Self {
            parsed,
            first,
            steps: Vec::new(),
        }
    }

    /// A program without steps, as before a sentence is parsed.
    pub const fn empty(model: &Model<'_>) -> Self {
        Self::new(Parsed::empty(model), 0)
    }

    /// Replaces a step that moves several objects by one for each; false if these are too many.
    ///
    /// * `stays`: id of the one that stays, where they are put in relation to each other
    pub(super) fn expand(&mut self, step: usize, ids: &[u32], stays: Option<u32>) -> bool {
        self.parsed.expand(step, ids, stays)
    }

    pub(super) fn push(&mut self, step: PlannedStep) {
        // As many places as the program has steps.
        let _ = self.steps.push(step);
    }
}
