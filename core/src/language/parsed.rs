use heapless::Vec;

use super::tokens::Corrections;
use super::{Correction, Span};
use crate::capacity::MAX_STEPS;
use crate::dsl::Program;
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
// Invariant: decisions for each step of the program; every index in it is one of the model's.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed {
    model_tag: u64,
    pub(super) program: Program,
    pub(super) decisions: Vec<StepDecisions, MAX_STEPS, u8>,
    pub(super) corrections: Corrections,
}

impl Parsed {
    /// Without steps, as before a sentence is parsed.
    pub const fn empty(model: &Model<'_>) -> Self {
        Self {
            model_tag: model.tag(),
            program: Program::new(),
            decisions: Vec::new(),
            corrections: Corrections::new(),
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
}
