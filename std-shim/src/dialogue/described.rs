//! Where a refused description stands in its sentence, and the program with another one there.

use nsrm_core::dsl::{Argument, Description, Filters, Relation, Step};
use nsrm_core::language::{Parsed, Reader, Span};
use nsrm_core::{Model, Planner, Program, Refusal, Scene};

/// A refused description in its sentence: that of an argument, or of what this is related to.
pub(super) struct Described {
    parsed: Parsed,
    step: usize,
    argument: Argument,
    /// Links of the chain outside of the description.
    level: usize,
    /// The place of its own concept words.
    pub(super) own: Span,
    /// Its place with all that it is related to.
    pub(super) whole: Span,
}

impl Described {
    /// `None` if no words of its own stand there, as in "the block left of the yellow one", or the
    /// refusal is about something else.
    pub(super) fn find(model: &Model<'_>, refusal: &Refusal, sentence: &str) -> Option<Self> {
        let (step, argument, refused) = refused(refusal)?;
        let step = usize::from(step);
        let parsed = Planner::new(model).parse(sentence).ok()?;
        let description = parsed.program().steps().get(step)?.description(argument);
        let level = level(description, refused)?;
        let decisions = parsed.decisions().get(step)?;
        let chain = match argument {
            Argument::Object => decisions.object_span,
            Argument::Reference => decisions.reference_span,
            _ => return None,
        };
        // Without values of its own the object has no group, and the anchors' begin.
        let group = match description.concepts() {
            [] => level.checked_sub(1)?,
            _ => level,
        };
        let (filters, own) = *groups(model, chain, sentence)?.get(group)?;
        // A misspelt word may have been read as another one than the first that is near.
        if filters != *refused.filters() {
            return None;
        }
        let whole = Span {
            start: own.start,
            end: chain.end,
        };
        Some(Self {
            parsed,
            step,
            argument,
            level,
            own,
            whole,
        })
    }

    /// The program with another description instead of it and all that it is related to; `None` if
    /// the chain has no room for the other's relations.
    pub(super) fn with(&self, other: &Description) -> Option<Program> {
        let mut program = Program::new();
        for (index, step) in self.parsed.program().steps().iter().enumerate() {
            let mut step: Step = *step;
            if index == self.step {
                let description = replaced(step.description(self.argument), self.level, other)?;
                match self.argument {
                    Argument::Reference => step.reference = description,
                    _ => step.object = description,
                }
            }
            // As many places as there are steps.
            let _ = program.push(step);
        }
        Some(program)
    }

    /// Id of the object that it refers to in a sentence with another description there.
    pub(super) fn chosen(&self, model: &Model<'_>, scene: &Scene, sentence: &str) -> Option<u32> {
        let plan = Planner::new(model).plan(scene, sentence).ok()?;
        let step = plan.steps().get(self.step)?;
        let grounding = match self.argument {
            Argument::Reference => &step.reference,
            _ => &step.object,
        };
        match self.level.checked_sub(1) {
            None => Some(grounding.object),
            Some(anchor) => grounding.anchors().get(anchor).copied(),
        }
    }

    /// Ids of the objects that the steps before its own move; `None` if these steps are not
    /// understood alone as they are in the sentence.
    pub(super) fn moved_before(
        &self,
        model: &Model<'_>,
        scene: &Scene,
        sentence: &str,
    ) -> Option<Vec<u32>> {
        if self.step == 0 {
            return Some(Vec::new());
        }
        let start = self.parsed.decisions().get(self.step)?.span.start;
        let (before, _) = sentence.split_at_checked(usize::from(start))?;
        let before = before.trim_end_matches([' ', ',']);
        let plan = Planner::new(model).plan(scene, before).ok()?;
        if Some(plan.program().steps()) != self.parsed.program().steps().get(..self.step) {
            return None;
        }
        Some(plan.sub_goals().map(|goal| goal.object).collect())
    }
}

/// The step, the argument and the description that a refusal is about, if it is of a single object.
pub(super) fn refused(refusal: &Refusal) -> Option<(u8, Argument, &Description)> {
    let found = match refusal {
        Refusal::Ambiguous {
            step,
            argument,
            description,
            ..
        }
        | Refusal::NoSuchObject {
            step,
            argument,
            description,
            ..
        } => Some((*step, *argument, description)),
        _ => None,
    };
    found.filter(|(.., description)| description.filters().quantifier().is_none())
}

/// How many links of a sentence's description are outside of the refused one.
pub(super) fn level(description: &Description, refused: &Description) -> Option<usize> {
    let (all, inside) = (description.relations().len(), refused.relations().len());
    let level = all.checked_sub(inside)?;
    (description.anchor(level).as_ref() == Some(refused)).then_some(level)
}

/// The description with another one from a link of its chain on.
fn replaced(description: &Description, level: usize, other: &Description) -> Option<Description> {
    let Some(last) = level.checked_sub(1) else {
        return Some(*other);
    };
    let mut replaced = Description::of(*description.filters());
    for (index, relation) in description.relations().iter().take(level).enumerate() {
        let filters = if index == last {
            other.filters()
        } else {
            &relation.to
        };
        let (kind, to) = (relation.kind, *filters);
        replaced.relate(Relation { kind, to }).ok()?;
    }
    for &relation in other.relations() {
        replaced.relate(relation).ok()?;
    }
    Some(replaced)
}

/// The groups of concept words at a place of the sentence.
fn groups(model: &Model<'_>, within: Span, sentence: &str) -> Option<Vec<(Filters, Span)>> {
    let mut reader = Reader::new(sentence).ok()?;
    while reader.advance(model, sentence).ok()? {}
    let groups = reader.tokens().iter();
    Some(
        groups
            .filter(|token| within.start <= token.span.start && token.span.end <= within.end)
            .filter_map(|token| Some((*token.filters()?, token.span)))
            .collect(),
    )
}
