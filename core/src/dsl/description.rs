use core::fmt;

use super::notation::{DescriptionWords, FilterWords, action_name, action_phrase};
use crate::capacity::{MAX_FILTERS, MAX_RELATIONS};
use crate::model::Model;

/// The concepts of one group of words, in the order of the sentence: indices into
/// [`Model::concepts`]. At most [`MAX_FILTERS`].
// Invariant: entries from `count` on are zero, so that equality may compare all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Filters {
    concepts: [u8; MAX_FILTERS],
    count: u8,
}

impl Filters {
    /// No concepts: every object passes.
    pub const fn new() -> Self {
        Self {
            concepts: [0; MAX_FILTERS],
            count: 0,
        }
    }

    /// Adds a concept; returns it if all places are taken.
    ///
    /// ```
    /// use nsrm_core::{MAX_FILTERS, dsl::Filters};
    /// let mut filters = Filters::new();
    /// for concept in 0..MAX_FILTERS as u8 {
    ///     filters.push(concept).unwrap();
    /// }
    /// assert_eq!(filters.push(7), Err(7));
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
        FilterWords {
            filters: self,
            model,
        }
    }
}

/// How an object is related to another one, the anchor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RelationKind {
    /// It is in the state that an action brings about: "left of" is where `MoveLeft` puts things.
    /// Index into [`Model::actions`].
    Action(u8),
    /// Of the objects that fit the filters, it is clearly the nearest to the anchor.
    Nearest,
    /// Of the objects that fit the filters, it is clearly the farthest from the anchor.
    Farthest,
}

impl RelationKind {
    /// The name in JSON and in the notation: that of the action, `"?"` for an invalid index,
    /// `Nearest` or `Farthest`.
    pub fn name<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Action(action) => action_name(model, action),
            Self::Nearest => "Nearest",
            Self::Farthest => "Farthest",
        }
    }

    /// How a person says it: the phrase of the action, `"?"` for an invalid index, `nearest to` or
    /// `farthest from`.
    pub fn phrase<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Action(action) => action_phrase(model, action),
            Self::Nearest => "nearest to",
            Self::Farthest => "farthest from",
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
            relations: [NONE; MAX_RELATIONS],
            count: 0,
        }
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
    /// to the left of yellow`.
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
        for (kind, own, expected) in [
            (RelationKind::Nearest, &[0][..], "red nearest to green"),
            (RelationKind::Farthest, &[], "what is farthest from green"),
        ] {
            let mut description = Description::of(filters(own));
            let to = filters(&[1]);
            description.relate(Relation { kind, to }).unwrap();
            assert_eq!(description.words(&model).to_string(), expected);
        }
    }
}
