//! Whose left is meant: "from the robot's point of view, put the red block to the left of the blue one".
//!
//! All is read from the person's point of view. Words that say so are left out, and so are those of the opposite one;
//! then each direction of the sentence is turned round. Nothing is learned here: the model lists what is said
//! ([`crate::model::Perspectives`]).

use core::ops::Range;

use super::Token;
use super::phrases::PhraseMatcher;
use crate::dsl::{Description, Extreme, Filters, Property, Relation, RelationKind, Step};
use crate::model::{CompoundKind, Model};

/// Words that say whose left is meant.
pub(super) struct SeenFrom {
    pub(super) words: Range<usize>,
    /// Whether it is the one opposite to the person's.
    pub(super) is_opposite: bool,
}

impl PhraseMatcher<'_, '_> {
    /// What says at a token whose left is meant.
    pub(super) fn seen_from(&self, tokens: &[Token], at: usize) -> Option<SeenFrom> {
        let perspectives = self.model.perspectives;
        let rest = tokens.get(at..)?;
        if !self.is_one_of(perspectives.first_words, rest.first()?) {
            return None;
        }
        let own = self.longest::<&str>(rest, perspectives.own);
        let other = self.longest::<&str>(rest, perspectives.other);
        let (length, _) = own.or(other)?;
        Some(SeenFrom {
            words: at..at.checked_add(length)?,
            is_opposite: own.is_none(),
        })
    }
}

/// A step with each direction turned round; `None` if the model has no name for one of them.
pub(super) fn turned(model: &Model<'_>, step: &Step) -> Option<Step> {
    Some(Step {
        action: opposite(model, step.action)?,
        object: turned_description(model, &step.object)?,
        reference: turned_description(model, &step.reference)?,
        distance_mm: step.distance_mm,
    })
}

fn turned_description(model: &Model<'_>, description: &Description) -> Option<Description> {
    let filters = turned_filters(model, description.filters())?;
    let except = description.except().copied().unwrap_or_default();
    let mut turned = Description::of(filters).excepting(except);
    for relation in description.relations() {
        let kind = match relation.kind {
            RelationKind::Action(action) => RelationKind::Action(opposite(model, action)?),
            kind => kind,
        };
        let to = turned_filters(model, &relation.to)?;
        // As many fit.
        let _ = turned.relate(Relation { kind, to });
    }
    Some(turned)
}

fn turned_filters(model: &Model<'_>, filters: &Filters) -> Option<Filters> {
    let mut turned = *filters;
    let (extreme, rank) = match filters.which(model) {
        Some((Extreme::Action(action), rank)) => (Extreme::Action(opposite(model, action)?), rank),
        _ => return Some(turned),
    };
    let mut ranked = model.ordinals.ranked.iter();
    let property = match rank {
        1 => Property::Extreme(extreme),
        _ => {
            let index = ranked.position(|each| each.extreme == extreme && each.rank == rank)?;
            Property::Ranked(u8::try_from(index).ok()?)
        }
    };
    // It replaces the other one.
    let _ = turned.add(property);
    Some(turned)
}

/// The action or compound in the opposite direction; itself if it has none.
fn opposite(model: &Model<'_>, action: u8) -> Option<u8> {
    let of = |action: u8| {
        model
            .perspectives
            .opposites
            .get(usize::from(action))
            .copied()
    };
    let Some(compound) = model.compound(action) else {
        return of(action);
    };
    if compound.kind != CompoundKind::All {
        // Next to and between look the same from both sides.
        return Some(action);
    }
    let is_opposite = |parts: &[u8]| {
        let mut own = compound.parts.iter();
        parts.len() == own.len()
            && own.all(|part| of(*part).is_some_and(|part| parts.contains(&part)))
    };
    let mut compounds = model.compounds.compounds.iter();
    let index =
        compounds.position(|other| other.kind == CompoundKind::All && is_opposite(other.parts))?;
    u8::try_from(model.actions.len().checked_add(index)?).ok()
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use crate::fixture;
    use crate::model::{Model, Perspectives};

    /// In which "on" and "right" are opposites.
    fn model() -> Model<'static> {
        let perspectives = Perspectives::new()
            .with_own(&["as i see it"])
            .with_other(&["as you see it", "from over there"])
            .with_first_words(&["as", "from"])
            .with_opposites(&[1, 0]);
        let model = fixture::with_compounds().with_perspectives(perspectives);
        assert_eq!(model.check(), Ok(()));
        model
    }

    fn read(sentence: &str) -> String {
        fixture::read(&model(), sentence)
    }

    #[test]
    fn directions_are_turned_round_for_someone_who_looks_the_other_way() {
        for (sentence, same) in [
            ("from over there, put red on green", "put red right green"),
            ("put red right green as you see it", "put red on green"),
            ("put, from over there, red on green", "put, red right green"),
            ("as i see it put red on green", "put red on green"),
            ("as you see it put red by green", "put red by green"),
            (
                "from over there put red on green then put lego right red",
                "put red right green then put lego on red",
            ),
        ] {
            assert!(read(same).starts_with("Action"), "{same}");
            assert_eq!(read(sentence), read(same), "{sentence}");
        }
        let diagonally = read("as you see it put red diagonally green");
        assert!(diagonally.starts_with("Action(RightOn"), "{diagonally}");
    }

    #[test]
    fn two_points_of_view_are_refused() {
        let refused = read("as i see it put red on green as you see it");
        assert_eq!(refused, "unclear_words");
        assert_eq!(read("as she sees it put red on green"), "unknown_word");
    }
}
