//! The domain-specific language (section IV-A, Table I): a program is a sequence
//! of `Action(a, Unique(Filter(…)), Unique(Filter(…)))`.
//!
//! A program is symbolic: it names actions and concepts by their index in the
//! model, and no object of any scene. [`Program::notation`] writes it as the
//! paper does.

use core::fmt;

use heapless::Vec;

use crate::capacity::{MAX_FILTERS, MAX_STEPS};
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

/// The concepts that describe one object, in the order of the sentence: indices into
/// [`Model::concepts`]. At most [`MAX_FILTERS`].
// Invariant: entries from `count` on are zero, so that equality may compare all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Description {
    concepts: [u8; MAX_FILTERS],
    count: u8,
}

impl Description {
    /// A description without concepts: every object fits it.
    pub const fn new() -> Self {
        Self {
            concepts: [0; MAX_FILTERS],
            count: 0,
        }
    }

    /// Adds a concept; returns it if the description is full.
    ///
    /// ```
    /// use nsrm_core::{MAX_FILTERS, dsl::Description};
    /// let mut description = Description::new();
    /// for concept in 0..MAX_FILTERS as u8 {
    ///     description.push(concept).unwrap();
    /// }
    /// assert_eq!(description.push(7), Err(7));
    /// ```
    pub fn push(&mut self, concept: u8) -> Result<(), u8> {
        let place = self
            .concepts
            .get_mut(usize::from(self.count))
            .ok_or(concept)?;
        *place = concept;
        self.count += 1;
        Ok(())
    }

    /// The concepts, in the order of the sentence.
    pub fn concepts(&self) -> &[u8] {
        self.concepts
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    /// The concepts' names, separated by spaces: `small green`.
    pub fn words<'a>(&'a self, model: &'a Model<'a>) -> impl fmt::Display + 'a {
        Words {
            description: self,
            model,
        }
    }
}

/// One step of a program: an action and the descriptions of its two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Step {
    /// Index into [`Model::actions`].
    pub action: u8,
    /// The object to move.
    pub object: Description,
    /// The reference object.
    pub reference: Description,
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
        StepNotation { step: self, model }
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
        ProgramNotation {
            program: self,
            model,
        }
    }
}

/// The name of a concept in the domain file; "?" for an invalid index.
pub(crate) fn concept_name<'a>(model: &Model<'a>, concept: u8) -> &'a str {
    model
        .concepts
        .get(usize::from(concept))
        .map_or("?", |concept| concept.name)
}

struct Words<'a> {
    description: &'a Description,
    model: &'a Model<'a>,
}

impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, &concept) in self.description.concepts().iter().enumerate() {
            if index > 0 {
                f.write_str(" ")?;
            }
            f.write_str(concept_name(self.model, concept))?;
        }
        Ok(())
    }
}

struct StepNotation<'a> {
    step: &'a Step,
    model: &'a Model<'a>,
}

impl StepNotation<'_> {
    fn unique(&self, description: &Description, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Unique(")?;
        for &concept in description.concepts() {
            write!(f, "Filter({}, ", concept_name(self.model, concept))?;
        }
        f.write_str("Scene()")?;
        for _ in description.concepts() {
            f.write_str(")")?;
        }
        f.write_str(")")
    }
}

impl fmt::Display for StepNotation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let action = self.model.actions.get(usize::from(self.step.action));
        write!(f, "Action({}, ", action.map_or("?", |action| action.name))?;
        self.unique(&self.step.object, f)?;
        f.write_str(", ")?;
        self.unique(&self.step.reference, f)?;
        f.write_str(")")
    }
}

struct ProgramNotation<'a> {
    program: &'a Program,
    model: &'a Model<'a>,
}

impl fmt::Display for ProgramNotation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.program.steps().iter().enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            step.notation(self.model).fmt(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::fixture;

    fn step(object: &[u8]) -> Step {
        let mut description = Description::new();
        for &concept in object {
            description.push(concept).unwrap();
        }
        Step {
            action: 0,
            object: description,
            reference: Description::new(),
        }
    }

    #[test]
    fn the_notation_is_the_papers_a_step_a_line() {
        let model = fixture::model();
        let mut program = Program::new();
        program.push(step(&[3, 1])).unwrap();
        program.push(step(&[9])).unwrap();
        assert_eq!(
            program.notation(&model).to_string(),
            "Action(MoveOn, Unique(Filter(small, Filter(green, Scene()))), Unique(Scene()))\n\
             Action(MoveOn, Unique(Filter(?, Scene())), Unique(Scene()))"
        );
    }

    #[test]
    fn a_full_program_gives_the_next_step_back() {
        let mut program = Program::new();
        for _ in 0..MAX_STEPS {
            program.push(step(&[0])).unwrap();
        }
        assert_eq!(program.push(step(&[1])), Err(step(&[1])));
    }
}
