//! What describes one object: what it is like, what is left out, and how it is related to others.

use core::fmt;

use super::Filters;
use super::notation::{DescriptionWords, action_name, action_phrase};
use crate::capacity::MAX_RELATIONS;
use crate::model::Model;

/// How an object is related to another one, the anchor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RelationKind {
    /// It is in the state that an action brings about: "left of" is where `MoveLeft` puts things.
    /// Index into [`Model::actions`], or behind these into
    /// [`Compounds::compounds`](crate::model::Compounds::compounds).
    Action(u8),
    /// Of the objects that fit the filters, it is clearly the nearest to the anchor.
    Nearest,
    /// Of the objects that fit the filters, it is clearly the farthest from the anchor.
    Farthest,
    /// None: the anchor is a further reference, of what is put or lies between two.
    And,
}

impl RelationKind {
    /// The name in JSON and in the notation: that of the action, `"?"` for an invalid index,
    /// `Nearest`, `Farthest` or `And`.
    pub fn name<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Action(action) => action_name(model, action),
            Self::Nearest => "Nearest",
            Self::Farthest => "Farthest",
            Self::And => "And",
        }
    }

    /// How a person says it: the phrase of the action, `"?"` for an invalid index, `nearest to`,
    /// `farthest from`, or `and`.
    pub fn phrase<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Action(action) => action_phrase(model, action),
            Self::Nearest => "nearest to",
            Self::Farthest => "farthest from",
            Self::And => "and",
        }
    }
}

impl Default for RelationKind {
    fn default() -> Self {
        Self::Action(0)
    }
}

/// A relation to another object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Relation {
    /// How the object is related to the other one.
    pub kind: RelationKind,
    /// The filters of the other object, the anchor.
    pub to: Filters,
}

/// What describes one object: filters, and relations in a chain, at most [`MAX_RELATIONS`].
///
/// The first relation is to an anchor, the next one restricts this anchor, and so on: "the red
/// block left of the yellow one on the white one" has the filter `red`, and the relations `MoveLeft`
/// to yellow and `MoveOn` to white. Filters without concepts are a noun without values: "the block
/// left of the yellow one".
// Invariant: relations from `count` on are the default, so that equality may compare all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Description {
    filters: Filters,
    except: Filters,
    relations: [Relation; MAX_RELATIONS],
    count: u8,
}

impl Description {
    /// A description without filters and relations: every object fits it.
    pub const fn new() -> Self {
        Self::of(Filters::new())
    }

    /// A description by filters alone.
    pub const fn of(filters: Filters) -> Self {
        const NONE: Relation = Relation {
            kind: RelationKind::Action(0),
            to: Filters::new(),
        };
        Self {
            filters,
            except: Filters::new(),
            relations: [NONE; MAX_RELATIONS],
            count: 0,
        }
    }

    /// The same without some objects: see [`Description::except`].
    #[must_use]
    pub const fn excepting(self, except: Filters) -> Self {
        Self { except, ..self }
    }

    /// What the objects look like that are not meant though all else fits, in "all blocks except the red one" or "the
    /// block that is not red": a single one of those that fit, or any number with [`Quantifier::All`](super::Quantifier::All); `None` if
    /// nothing is left out.
    pub fn except(&self) -> Option<&Filters> {
        Some(&self.except).filter(|except| !except.concepts().is_empty())
    }

    /// Whether both say the same, with the concepts in whatever order.
    pub fn says_same(&self, other: &Self) -> bool {
        let (these, those) = (self.relations(), other.relations());
        self.filters.says_same(&other.filters)
            && self.except.says_same(&other.except)
            && these.len() == those.len()
            && these
                .iter()
                .zip(those)
                .all(|(this, that)| this.kind == that.kind && this.to.says_same(&that.to))
    }

    /// What the object itself looks like.
    pub const fn filters(&self) -> &Filters {
        &self.filters
    }

    /// The concepts of [`Description::filters`].
    pub fn concepts(&self) -> &[u8] {
        self.filters.concepts()
    }

    /// The relations, from the object's own to that of the innermost anchor.
    pub fn relations(&self) -> &[Relation] {
        self.relations
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    /// Adds a relation of the innermost anchor, or of the object if it has none yet; returns it if
    /// the chain is full.
    ///
    /// ```
    /// use nsrm_core::{MAX_RELATIONS, dsl::{Description, Relation}};
    /// let mut description = Description::new();
    /// for _ in 0..MAX_RELATIONS {
    ///     description.relate(Relation::default()).unwrap();
    /// }
    /// assert_eq!(description.relate(Relation::default()), Err(Relation::default()));
    /// ```
    pub fn relate(&mut self, relation: Relation) -> Result<(), Relation> {
        let place = self
            .relations
            .get_mut(usize::from(self.count))
            .ok_or(relation)?;
        *place = relation;
        self.count += 1;
        Ok(())
    }

    /// The description that is left when the first links of the chain are taken off: of the object
    /// itself (`level` 0), of what its relation refers to (1), and so on; `None` behind the end of
    /// the chain.
    pub fn anchor(&self, level: usize) -> Option<Self> {
        let Some(taken_off) = level.checked_sub(1) else {
            return Some(*self);
        };
        let relations = self.relations();
        let mut anchor = Self::of(relations.get(taken_off)?.to);
        for &relation in relations.iter().skip(level) {
            // A shorter chain has room.
            let _ = anchor.relate(relation);
        }
        Some(anchor)
    }

    /// In words: `small green`, `red to the left of yellow`, and without values of its own `what is
    /// to the left of yellow` and `leftmost of what is on yellow`.
    pub fn words<'a>(&'a self, model: &'a Model<'a>) -> impl fmt::Display + 'a {
        DescriptionWords {
            description: self,
            model,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::dsl::{Extreme, Property, Quantifier};
    use crate::fixture::{self, filters};

    /// With relations to the right of, and then on, objects of these concepts.
    fn chain(own: &[u8], anchors: &[&[u8]]) -> Description {
        let mut description = Description::of(filters(own));
        for (action, concepts) in [1, 0].into_iter().zip(anchors) {
            let (kind, to) = (RelationKind::Action(action), filters(concepts));
            description.relate(Relation { kind, to }).unwrap();
        }
        description
    }

    #[test]
    fn an_anchor_is_what_is_left_of_the_chain() {
        let whole = chain(&[0], &[&[3, 1], &[2]]);
        assert_eq!(whole.anchor(0), Some(whole));
        let mut first = Description::of(filters(&[3, 1]));
        let to = filters(&[2]);
        let kind = RelationKind::Action(0);
        first.relate(Relation { kind, to }).unwrap();
        assert_eq!(whole.anchor(1), Some(first));
        assert_eq!(whole.anchor(2), Some(Description::of(to)));
        assert_eq!(whole.anchor(3), None);
        assert_eq!(Description::new().anchor(1), None);
        assert_eq!(Description::new(), Description::default());
    }

    #[test]
    fn words_read_well_with_and_without_values_of_its_own() {
        let model = fixture::model();
        let said = |own: &[u8], anchors: &[&[u8]]| chain(own, anchors).words(&model).to_string();
        assert_eq!(said(&[3, 1], &[]), "small green");
        assert_eq!(said(&[0], &[&[1]]), "red to the right of green");
        assert_eq!(
            said(&[0], &[&[3, 1], &[2]]),
            "red to the right of small green on lego"
        );
        assert_eq!(said(&[], &[&[1]]), "what is to the right of green");
        let mut which = filters(&[3, 1]);
        which.add(Property::Extreme(Extreme::Action(1))).unwrap();
        assert_eq!(which.words(&model).to_string(), "rightmost small green");
        let mut only = Filters::new();
        only.add(Property::Extreme(Extreme::Action(0))).unwrap();
        assert!(!only.is_empty() && Filters::new().is_empty());
        let mut description = Description::of(only);
        assert_eq!(description.words(&model).to_string(), "topmost");
        let kind = RelationKind::Action(1);
        description.relate(Relation { kind, to: which }).unwrap();
        assert_eq!(
            description.words(&model).to_string(),
            "topmost of what is to the right of rightmost small green"
        );
        let mut all = filters(&[0]);
        all.add(Property::Quantifier(Quantifier::All)).unwrap();
        assert_eq!(all.words(&model).to_string(), "all red");
        // Which one, the id says.
        assert_eq!(all.of_each().words(&model).to_string(), "red");
        assert_eq!(Extreme::Action(7).name(&model), "?");
        assert_eq!(Extreme::Largest.name(&model), "largest");
        for (kind, own, expected) in [
            (RelationKind::Nearest, &[0][..], "red nearest to green"),
            (RelationKind::Farthest, &[], "what is farthest from green"),
            (RelationKind::And, &[0], "red and green"),
        ] {
            let mut description = Description::of(filters(own));
            let to = filters(&[1]);
            description.relate(Relation { kind, to }).unwrap();
            assert_eq!(description.words(&model).to_string(), expected);
        }
    }
}
