//! Programs as text: in the paper's notation, and descriptions in words.

use core::fmt;
use core::num::NonZeroU16;

use super::{Description, Filters, Program, Property, Quantifier, Step};
use crate::model::Model;

/// The name of a concept in the domain file; "?" for an invalid index.
pub(super) fn concept_name<'a>(model: &Model<'a>, concept: u8) -> &'a str {
    model
        .concepts
        .get(usize::from(concept))
        .map_or("?", |concept| concept.name)
}

/// The name of an action or a compound in the domain file; "?" for an invalid index.
pub(super) fn action_name<'a>(model: &Model<'a>, action: u8) -> &'a str {
    model.action_name(action).unwrap_or("?")
}

/// An action's word for what lies farthest in its direction; "?" for an invalid index and for an
/// action without one.
pub(super) fn extreme_name<'a>(model: &Model<'a>, action: u8) -> &'a str {
    let action = model.actions.get(usize::from(action));
    action.and_then(|action| action.extreme).unwrap_or("?")
}

/// How a person says an action or a compound; "?" for an invalid index.
pub(crate) fn action_phrase<'a>(model: &Model<'a>, action: u8) -> &'a str {
    match model.actions.get(usize::from(action)) {
        Some(action) => action.phrase,
        None => model
            .compound(action)
            .map_or("?", |compound| compound.phrase),
    }
}

pub(super) struct FilterWords<'a> {
    pub(super) filters: &'a Filters,
    pub(super) model: &'a Model<'a>,
}

impl fmt::Display for FilterWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // "Each red" would say too much of one of them.
        let each = Property::Quantifier(Quantifier::Each);
        let which = self.filters.choice().filter(|choice| *choice != each);
        let concepts = self.filters.concepts().iter();
        let concepts = concepts.map(|&concept| Property::Concept(concept));
        for (index, property) in which.into_iter().chain(concepts).enumerate() {
            if index > 0 {
                f.write_str(" ")?;
            }
            f.write_str(property.name(self.model))?;
        }
        Ok(())
    }
}

pub(super) struct DescriptionWords<'a> {
    pub(super) description: &'a Description,
    pub(super) model: &'a Model<'a>,
}

impl fmt::Display for DescriptionWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relations = self.description.relations();
        let filters = self.description.filters();
        filters.words(self.model).fmt(f)?;
        if let Some(except) = self.description.except() {
            let separator = if filters.is_empty() { "" } else { " " };
            write!(
                f,
                "{separator}except {}",
                except.of_each().words(self.model)
            )?;
        }
        if filters.concepts().is_empty() && !relations.is_empty() {
            f.write_str(match filters.choice() {
                Some(Property::Quantifier(_)) => " that are",
                Some(_) => " of what is",
                None => "what is",
            })?;
        }
        for relation in relations {
            let phrase = relation.kind.phrase(self.model);
            write!(f, " {phrase} {}", relation.to.words(self.model))?;
        }
        Ok(())
    }
}

/// The table, which is no object of the scene.
const TABLE: &str = "Table()";

pub(super) struct StepNotation<'a> {
    pub(super) step: &'a Step,
    pub(super) model: &'a Model<'a>,
}

impl StepNotation<'_> {
    fn unique(&self, description: &Description, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match description.filters().choice() {
            Some(Property::Table) => return f.write_str(TABLE),
            Some(Property::Itself) => return f.write_str("Itself()"),
            _ => {}
        }
        let mut open = self.open(description.filters(), description.except(), f)?;
        for relation in description.relations() {
            write!(f, "Relate({}, ", relation.kind.name(self.model))?;
            if relation.to.is_table() {
                return self.close(TABLE, open + 1, f);
            }
            open += 1 + self.open(&relation.to, None, f)?;
        }
        self.close("Scene()", open, f)
    }

    /// Writes the innermost term and so many closing brackets.
    fn close(&self, term: &str, open: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(term)?;
        for _ in 0..open {
            f.write_str(")")?;
        }
        Ok(())
    }

    /// Writes `Unique(Extreme(…, 2, Except(…, Filter(…, ` up to what is filtered; returns the number of open
    /// brackets.
    fn open(
        &self,
        filters: &Filters,
        except: Option<&Filters>,
        f: &mut fmt::Formatter<'_>,
    ) -> Result<usize, fmt::Error> {
        let quantifier = filters.quantifier();
        f.write_str(quantifier.map_or("Unique", Quantifier::symbol))?;
        f.write_str("(")?;
        let which = filters.which(self.model);
        if let Some((extreme, rank)) = which {
            write!(f, "Extreme({}, ", extreme.symbol(self.model))?;
            if rank > 1 {
                write!(f, "{rank}, ")?;
            }
        }
        if let Some(except) = except {
            f.write_str("Except(")?;
            let open = self.open(except, None, f)?;
            self.close("Scene()", open, f)?;
            f.write_str(", ")?;
        }
        for &concept in filters.concepts() {
            write!(f, "Filter({}, ", concept_name(self.model, concept))?;
        }
        let around = [true, which.is_some(), except.is_some()];
        let around = around.into_iter().filter(|is_there| *is_there).count();
        Ok(around + filters.concepts().len())
    }
}

impl fmt::Display for StepNotation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Action({}, ", action_name(self.model, self.step.action))?;
        self.unique(&self.step.object, f)?;
        f.write_str(", ")?;
        self.unique(&self.step.reference, f)?;
        if let Some(mm) = self.step.distance_mm {
            write!(f, ", Distance({})", Metres(mm))?;
        }
        f.write_str(")")
    }
}

/// A length in metres with three decimal places.
struct Metres(NonZeroU16);

impl fmt::Display for Metres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = self.0.get();
        write!(f, "{}.{:03}", mm / 1000, mm % 1000)
    }
}

pub(super) struct ProgramNotation<'a> {
    pub(super) program: &'a Program,
    pub(super) model: &'a Model<'a>,
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

    use super::super::{Extreme, Relation, RelationKind};
    use super::*;
    use crate::fixture::{self, filters};

    fn step(object: Description) -> Step {
        Step {
            action: 0,
            object,
            reference: Description::new(),
            distance_mm: None,
        }
    }

    #[test]
    fn the_notation_is_the_papers_a_step_a_line() {
        let model = fixture::model();
        let mut program = Program::new();
        for concepts in [&[3, 1][..], &[9]] {
            let object = Description::of(filters(concepts));
            program.push(step(object)).unwrap();
        }
        assert_eq!(
            program.notation(&model).to_string(),
            "Action(MoveOn, Unique(Filter(small, Filter(green, Scene()))), Unique(Scene()))\n\
             Action(MoveOn, Unique(Filter(?, Scene())), Unique(Scene()))"
        );
    }

    #[test]
    fn a_relation_filters_by_the_object_that_it_refers_to() {
        let model = fixture::model();
        let mut object = Description::of(filters(&[0]));
        for (action, concepts) in [(1, &[3, 1][..]), (0, &[2])] {
            let (kind, to) = (RelationKind::Action(action), filters(concepts));
            object.relate(Relation { kind, to }).unwrap();
        }
        assert_eq!(
            step(object).notation(&model).to_string(),
            "Action(MoveOn, Unique(Filter(red, Relate(MoveRight, Unique(Filter(small, \
             Filter(green, Relate(MoveOn, Unique(Filter(lego, Scene()))))))))), Unique(Scene()))"
        );
        let mut which = filters(&[3]);
        which.add(Property::Extreme(Extreme::Action(1))).unwrap();
        let mut object = Description::of(which);
        let kind = RelationKind::Nearest;
        object.relate(Relation { kind, to: which }).unwrap();
        assert_eq!(
            step(object).notation(&model).to_string(),
            "Action(MoveOn, Unique(Extreme(MoveRight, Filter(small, Relate(Nearest, \
             Unique(Extreme(MoveRight, Filter(small, Scene()))))))), Unique(Scene()))"
        );
        for (quantifier, symbol) in [
            (Quantifier::All, "All"),
            (Quantifier::Both, "Both"),
            (Quantifier::Each, "Each"),
        ] {
            let mut several = filters(&[0]);
            several.add(Property::Quantifier(quantifier)).unwrap();
            assert_eq!(
                step(Description::of(several)).notation(&model).to_string(),
                std::format!("Action(MoveOn, {symbol}(Filter(red, Scene())), Unique(Scene()))")
            );
        }
        let mut largest = Filters::new();
        largest.add(Property::Extreme(Extreme::Largest)).unwrap();
        assert_eq!(
            step(Description::of(largest)).notation(&model).to_string(),
            "Action(MoveOn, Unique(Extreme(Largest, Scene())), Unique(Scene()))"
        );
        for (kind, name) in [
            (RelationKind::Action(7), "?"),
            (RelationKind::Nearest, "Nearest"),
            (RelationKind::Farthest, "Farthest"),
            (RelationKind::And, "And"),
        ] {
            let mut object = Description::new();
            let to = filters(&[1]);
            object.relate(Relation { kind, to }).unwrap();
            assert_eq!(
                step(object).notation(&model).to_string(),
                std::format!(
                    "Action(MoveOn, Unique(Relate({name}, Unique(Filter(green, Scene())))), \
                     Unique(Scene()))"
                )
            );
        }
    }
}
