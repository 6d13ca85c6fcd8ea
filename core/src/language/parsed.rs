use heapless::Vec;

use super::tokens::Corrections;
use super::{Correction, Span};
use crate::capacity::MAX_STEPS;
use crate::dsl::{Argument, Description, Program, Quantifier, Step};
use crate::model::Model;

/// The parser's confidence in a step; probabilities.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StepDecisions {
    /// The step's place in the sentence.
    pub span: Span,
    /// The place of the words that describe the object to move: from its first concept word to the
    /// last one of its relations.
    pub object_span: Span,
    /// The place of the words that describe the reference.
    pub reference_span: Span,
    /// That the step ends where it was split.
    pub split: f32,
    /// That all its words stand where commands have them.
    pub words: f32,
    /// That its action is right.
    pub action: f32,
    /// That each group of concept words is related to another one as it was read, or to none.
    pub relations: f32,
    /// That the chosen words describe the object to move.
    pub object: f32,
    /// That the chosen words describe the reference.
    pub reference: f32,
}

/// A program parsed by a model, with the parser's confidence in each step.
///
/// Apart from an empty one, only a completed [`super::ParsingTask`] creates one: its actions and
/// concepts exist in that model, and it has decisions for each step. So grounding it with that
/// model, which [`crate::Planner::begin_grounding`] checks, always finds them.
///
/// ```compile_fail
/// use nsrm_core::{Program, language::Parsed};
/// let (program, decisions) = (Program::new(), Default::default());
/// let parsed = Parsed { program, decisions };
/// ```
///
/// Grounding replaces a step that moves several objects by one for each, which it is bound to.
// Invariant: decisions for each step of the program; every index in it is one of the model's.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed {
    model_tag: u64,
    pub(super) program: Program,
    pub(super) decisions: Vec<StepDecisions, MAX_STEPS, u8>,
    pub(super) corrections: Corrections,
    /// Ids of the objects that steps move whose description is `Quantifier::Each`.
    each: [u32; MAX_STEPS],
    /// Ids of the references of those of these steps that are put in relation to one that stays, 0 for others.
    stays: [u32; MAX_STEPS],
}

impl Parsed {
    /// Without steps, as before a sentence is parsed.
    pub const fn empty(model: &Model<'_>) -> Self {
        Self {
            model_tag: model.tag(),
            program: Program::new(),
            decisions: Vec::new(),
            corrections: Corrections::new(),
            each: [0; MAX_STEPS],
            stays: [0; MAX_STEPS],
        }
    }

    /// [`Model::tag`] of the model that parsed it.
    pub const fn model_tag(&self) -> u64 {
        self.model_tag
    }

    /// What is to be done.
    pub const fn program(&self) -> &Program {
        &self.program
    }

    /// The parser's confidence in each step of the program.
    pub fn decisions(&self) -> &[StepDecisions] {
        &self.decisions
    }

    /// Misspelt words of the sentence, and what they were read as: tell the person.
    pub fn corrections(&self) -> &[Correction] {
        &self.corrections
    }

    /// The id of the object that one of several is; `None` if another description is meant.
    pub(crate) fn each(&self, step: usize, argument: Argument) -> Option<u32> {
        let description = self.program.steps().get(step)?.description(argument);
        let is_each = description.filters().quantifier() == Some(Quantifier::Each);
        let stays = self.stays.get(step).copied().filter(|id| *id > 0);
        // What is put beside or on one of several follows the step that moved it.
        let id = match (argument, stays) {
            (Argument::Object, _) => self.each.get(step).copied(),
            (Argument::Reference, Some(stays)) => Some(stays),
            (Argument::Reference, None) => self.each.get(step.checked_sub(1)?).copied(),
        };
        id.filter(|_| is_each)
    }

    /// Replaces a step that moves several objects by one for each, in this order: the first one is
    /// moved in relation to the step's reference, and each of the others in relation to the one before
    /// it, "all red blocks on the blue one" one on the other. On the table, each has a place of its own. Where they are
    /// put in relation to each other, "stack all red blocks", the one that stays is the first's reference.
    /// False, and without a use, if these are too many steps.
    ///
    /// * `ids`: those of the objects, at least one
    /// * `stays`: that of the one that stays
    pub(crate) fn expand(&mut self, step: usize, ids: &[u32], stays: Option<u32>) -> bool {
        let before = core::mem::take(&mut self.program);
        let decided = core::mem::take(&mut self.decisions);
        let bound = core::mem::take(&mut self.each);
        let stay = core::mem::take(&mut self.stays);
        let bound = bound.into_iter().zip(stay);
        let mut fits = true;
        let steps = before.steps().iter().zip(&decided).zip(bound);
        for (number, ((symbols, decisions), each)) in steps.enumerate() {
            if number != step {
                fits &= self.add(*symbols, *decisions, each);
                continue;
            }
            let one = Description::of(symbols.object.filters().of_each());
            let reference = stays.map_or(symbols.reference, |_| one);
            let mut next = (reference, *decisions, stays.unwrap_or(0));
            for &id in ids {
                let (reference, decisions, stays) = next;
                let moved = Step {
                    object: one,
                    reference,
                    ..*symbols
                };
                fits &= self.add(moved, decisions, (id, stays));
                // What was decided once is not doubted twice.
                let is_other = symbols.reference.filters().is_other_object();
                let reference = match is_other || reference == one {
                    true => one,
                    false => symbols.reference,
                };
                next = (reference, decisions.certain(), 0);
            }
        }
        fits
    }

    fn add(&mut self, symbols: Step, decisions: StepDecisions, (each, stays): (u32, u32)) -> bool {
        let number = self.decisions.len();
        let places = self.each.get_mut(number).zip(self.stays.get_mut(number));
        let Some(place) = places else {
            return false;
        };
        (*place.0, *place.1) = (each, stays);
        self.program.push(symbols).is_ok() && self.decisions.push(decisions).is_ok()
    }
}

impl StepDecisions {
    /// The same, decided before.
    const fn certain(self) -> Self {
        Self {
            split: 1.0,
            words: 1.0,
            action: 1.0,
            relations: 1.0,
            object: 1.0,
            reference: 1.0,
            ..self
        }
    }
}
