//! The domain-specific language (section IV-A, Table I): a program is a sequence
//! of `Action(a, Unique(Filter(…)), Unique(Filter(…)))`. Beyond the paper, a description may refer
//! to another one by a relation, `Unique(Filter(red, Relate(MoveLeft, Unique(…))))`, and say which of
//! several objects it means, `Unique(Extreme(MoveLeft, Filter(red, …)))`, "the leftmost red one", and
//! `Extreme(MoveLeft, 2, …)`, "the second red one from the left", or that what is moved are several, `All(Filter(red, …))`, "all red ones". Between two objects, the
//! second one is named by `Relate(And, Unique(…))`.
//!
//! A program is symbolic: it names actions and concepts by their index in the
//! model, and no object of any scene. [`Program::notation`] writes it as the
//! paper does.

mod description;
mod filters;
mod notation;

pub use description::{Description, Relation, RelationKind};
pub use filters::{Extreme, Filters, Property, Quantifier};
pub(crate) use notation::action_phrase;

use core::fmt;
use core::num::NonZeroU16;

use heapless::Vec;

use crate::capacity::MAX_STEPS;
use crate::model::Model;

/// One of an action's two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Argument {
    /// The object that is moved, the paper's `o_1`.
    Object,
    /// The reference object, the paper's `o_2`.
    Reference,
}

impl Argument {
    /// The name in snake case, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Reference => "reference",
        }
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One step of a program: an action and the descriptions of its two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Step {
    /// Index into [`Model::actions`], or behind these into [`Compounds::compounds`](crate::model::Compounds::compounds).
    pub action: u8,
    /// The object to move.
    pub object: Description,
    /// The reference object.
    pub reference: Description,
    /// The distance between the faces of the two, millimetres, where the sentence names one; otherwise it is that of the
    /// demonstrations. With [`Property::Itself`] as the reference, that by which the object is moved.
    pub distance_mm: Option<NonZeroU16>,
}

impl Step {
    /// The description of one of the arguments.
    pub const fn description(&self, argument: Argument) -> &Description {
        match argument {
            Argument::Object => &self.object,
            Argument::Reference => &self.reference,
        }
    }

    /// The step in the paper's notation.
    pub fn notation<'a>(&'a self, model: &'a Model<'a>) -> impl fmt::Display + 'a {
        notation::StepNotation { step: self, model }
    }
}

/// The steps of a sentence; at most [`MAX_STEPS`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Program {
    steps: Vec<Step, MAX_STEPS, u8>,
}

impl Program {
    /// A program without steps.
    pub const fn new() -> Self {
        Self { steps: Vec::new() }
    }

    /// Adds a step; returns it if the program is full.
    pub fn push(&mut self, step: Step) -> Result<(), Step> {
        self.steps.push(step)
    }

    /// The steps, in the order of execution.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The program in the paper's notation, one step per line: `Action(MoveOn, Unique(Filter(red,
    /// Scene())), Unique(Filter(blue, Scene())))`.
    ///
    /// ```
    /// use nsrm_core::Planner;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// let parsed = Planner::new(&TABLETOP).parse("put the red block on the small blue block")?;
    /// assert_eq!(
    ///     parsed.program().notation(&TABLETOP).to_string(),
    ///     "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(small, Filter(blue, Scene()))))"
    /// );
    /// # Ok::<(), nsrm_core::Refusal>(())
    /// ```
    pub fn notation<'a>(&'a self, model: &'a Model<'a>) -> impl fmt::Display + 'a {
        notation::ProgramNotation {
            program: self,
            model,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_program_gives_the_next_step_back() {
        let step = |action| Step {
            action,
            object: Description::new(),
            reference: Description::new(),
            distance_mm: None,
        };
        let mut program = Program::new();
        for _ in 0..MAX_STEPS {
            program.push(step(0)).unwrap();
        }
        assert_eq!(program.push(step(1)), Err(step(1)));
    }
}
