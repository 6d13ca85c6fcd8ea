//! What words say of one object: its values, which one of several it is, and that several are meant.

use core::fmt;

use super::notation::{FilterWords, action_name, concept_name, extreme_name};
use crate::capacity::MAX_FILTERS;
use crate::model::Model;

/// What a word of the lexicon says of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// What it looks like, "red": index into [`Model::concepts`].
    Concept(u8),
    /// Which one of several it is, "leftmost".
    Extreme(Extreme),
    /// Which one of several it is, counted from an extreme, "second from the left": index into
    /// [`Ordinals::ranked`](crate::model::Ordinals::ranked).
    Ranked(u8),
    /// That several objects are meant, "all".
    Quantifier(Quantifier),
    /// That it is the table, on which objects stand, and no object.
    Table,
    /// That it is the object that is moved: "5 cm to the left" is seen from where it is; of several that are moved, each
    /// other one: "stack the red blocks". No word of the lexicon says so.
    Itself,
}

impl Property {
    /// The name of the concept, of the extreme or of what is counted from it, `"?"` if the model has none;
    /// `all`, `both`, `each`, `table` or `itself`.
    pub fn name<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Concept(concept) => concept_name(model, concept),
            Self::Extreme(extreme) => extreme.name(model),
            Self::Ranked(index) => {
                let named = model.ordinals.ranked.get(usize::from(index));
                named.map_or("?", |named| named.name)
            }
            Self::Quantifier(quantifier) => quantifier.name(),
            Self::Table => "table",
            Self::Itself => "itself",
        }
    }

    /// Which of the objects that pass the filters, as a number in messages and in C: 1 for the
    /// largest, 2 for the smallest, 3 plus the index of an action; for several, 512 for all, 513
    /// for both, 514 for each; 515 for the table, 516 for the object itself; and 1,024 plus the index of
    /// what is counted from an extreme. 0 is left for none; a concept has none.
    pub const fn which_number(self) -> u32 {
        match self {
            Self::Concept(_) => 0,
            Self::Extreme(Extreme::Largest) => 1,
            Self::Extreme(Extreme::Smallest) => 2,
            Self::Extreme(Extreme::Action(action)) => 3 + action as u32,
            Self::Ranked(index) => COUNTED + index as u32,
            Self::Quantifier(Quantifier::All) => QUANTIFIED,
            Self::Quantifier(Quantifier::Both) => QUANTIFIED + 1,
            Self::Quantifier(Quantifier::Each) => QUANTIFIED + 2,
            Self::Table => QUANTIFIED + 3,
            Self::Itself => QUANTIFIED + 4,
        }
    }

    /// What [`Property::which_number`] means, if it is one.
    pub fn of_which_number(number: u32) -> Option<Self> {
        Some(match number {
            0 => return None,
            1 => Self::Extreme(Extreme::Largest),
            2 => Self::Extreme(Extreme::Smallest),
            QUANTIFIED => Self::Quantifier(Quantifier::All),
            513 => Self::Quantifier(Quantifier::Both),
            514 => Self::Quantifier(Quantifier::Each),
            515 => Self::Table,
            516 => Self::Itself,
            COUNTED.. => Self::Ranked(u8::try_from(number - COUNTED).ok()?),
            _ => Self::Extreme(Extreme::Action(u8::try_from(number - 3).ok()?)),
        })
    }
}

/// Number of the first quantifier, behind those of all actions.
const QUANTIFIED: u32 = 512;

/// Number of what is counted from an extreme first.
const COUNTED: u32 = 1024;

/// How many of the objects that pass filters are meant, if not a single one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantifier {
    /// All that fit, apart from the reference.
    All,
    /// All that fit, which are two.
    Both,
    /// One of those that a step with one of the others moves: such a step becomes one of these for
    /// each object once it is grounded, and no word says it.
    Each,
}

impl Quantifier {
    /// The name: `all`, `both` or `each`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Both => "both",
            Self::Each => "each",
        }
    }

    /// The name in the notation, in place of `Unique`.
    pub(super) const fn symbol(self) -> &'static str {
        match self {
            Self::All => "All",
            Self::Both => "Both",
            Self::Each => "Each",
        }
    }
}

/// Which of the objects that pass filters is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extreme {
    /// The one that lies farthest in the direction in which an action puts things: "leftmost" is that
    /// of `MoveLeft`. Index into [`Model::actions`].
    Action(u8),
    /// The one of the largest volume: "biggest".
    Largest,
    /// The one of the smallest volume.
    Smallest,
}

impl Extreme {
    /// The name: the action's word, [`crate::model::Action::extreme`], `"?"` for an invalid index,
    /// `largest` or `smallest`.
    pub fn name<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Action(action) => extreme_name(model, action),
            Self::Largest => "largest",
            Self::Smallest => "smallest",
        }
    }

    /// The name in the notation: that of the action, `"?"` for an invalid index, `Largest` or
    /// `Smallest`.
    pub(super) fn symbol<'a>(self, model: &Model<'a>) -> &'a str {
        match self {
            Self::Action(action) => action_name(model, action),
            Self::Largest => "Largest",
            Self::Smallest => "Smallest",
        }
    }
}

/// The concepts of one group of words, in the order of the sentence: indices into
/// [`Model::concepts`], at most [`MAX_FILTERS`]; and which of the objects that have them is meant, or
/// that several are, if the words say so.
// Invariant: entries from `count` on are zero, so that equality may compare all; the choice is no
// concept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Filters {
    concepts: [u8; MAX_FILTERS],
    count: u8,
    choice: Option<Property>,
}

impl Filters {
    /// No concepts: every object passes.
    pub const fn new() -> Self {
        Self {
            concepts: [0; MAX_FILTERS],
            count: 0,
            choice: None,
        }
    }

    /// Adds what a word says; returns it if all places are taken. A second extreme or quantifier
    /// replaces the first.
    pub fn add(&mut self, property: Property) -> Result<(), Property> {
        match property {
            Property::Concept(concept) => self.push(concept).map_err(Property::Concept),
            Property::Extreme(_)
            | Property::Ranked(_)
            | Property::Quantifier(_)
            | Property::Table
            | Property::Itself => {
                self.choice = Some(property);
                Ok(())
            }
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

    /// Which of the objects that pass is meant, that several are, or that it is the table or the object
    /// itself: no concept; `None` if the words leave that open.
    pub const fn choice(&self) -> Option<Property> {
        self.choice
    }

    /// Which of the objects that pass, as an extreme and the number counted from there, 1 for the extreme
    /// itself; `None` if the words leave that open, and for an index that the model hasn't.
    pub fn which(&self, model: &Model<'_>) -> Option<(Extreme, u8)> {
        match self.choice? {
            Property::Extreme(extreme) => Some((extreme, 1)),
            Property::Ranked(index) => {
                let ranked = model.ordinals.ranked.get(usize::from(index))?;
                Some((ranked.extreme, ranked.rank))
            }
            _ => None,
        }
    }

    /// Whether the object is told by comparing those that pass.
    pub const fn is_compared(&self) -> bool {
        matches!(
            self.choice,
            Some(Property::Extreme(_) | Property::Ranked(_))
        )
    }

    /// How many of the objects that pass; `None` if a single one is meant.
    pub const fn quantifier(&self) -> Option<Quantifier> {
        match self.choice {
            Some(Property::Quantifier(quantifier)) => Some(quantifier),
            _ => None,
        }
    }

    /// Whether they mean the table, and no object.
    pub const fn is_table(&self) -> bool {
        matches!(self.choice, Some(Property::Table))
    }

    /// Whether they mean the object that is moved.
    pub const fn is_itself(&self) -> bool {
        matches!(self.choice, Some(Property::Itself))
    }

    /// Whether they mean another object of the scene: neither the table nor the object that is moved.
    pub const fn is_other_object(&self) -> bool {
        !self.is_table() && !self.is_itself()
    }

    /// The same with each concept once: "the big red lego" says one twice.
    pub(crate) fn distinct(&self) -> Self {
        let mut distinct = Self {
            choice: self.choice,
            ..Self::new()
        };
        for &concept in self.concepts() {
            if !distinct.concepts().contains(&concept) {
                // There was room for more.
                let _ = distinct.push(concept);
            }
        }
        distinct
    }

    /// The same of each of several objects.
    pub(crate) const fn of_each(self) -> Self {
        let choice = Some(Property::Quantifier(Quantifier::Each));
        Self { choice, ..self }
    }

    /// Whether both say the same, with the concepts in whatever order.
    pub fn says_same(&self, other: &Self) -> bool {
        let all = |these: &Self, those: &Self| {
            let mut concepts = these.concepts().iter();
            concepts.all(|concept| those.concepts().contains(concept))
        };
        all(self, other) && all(other, self) && self.choice == other.choice
    }

    /// Whether they say nothing, as those of "the block left of the yellow one".
    pub const fn is_empty(&self) -> bool {
        self.count == 0 && self.choice.is_none()
    }

    /// In words: `small green`, `leftmost small green`, `all small green`.
    pub fn words<'a>(&'a self, model: &'a Model<'a>) -> impl fmt::Display + 'a {
        FilterWords {
            filters: self,
            model,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn which_objects_has_a_number() {
        for property in [
            Property::Extreme(Extreme::Largest),
            Property::Extreme(Extreme::Smallest),
            Property::Extreme(Extreme::Action(0)),
            Property::Extreme(Extreme::Action(255)),
            Property::Quantifier(Quantifier::All),
            Property::Quantifier(Quantifier::Both),
            Property::Quantifier(Quantifier::Each),
            Property::Table,
            Property::Itself,
            Property::Ranked(0),
            Property::Ranked(255),
        ] {
            let number = property.which_number();
            assert_eq!(Property::of_which_number(number), Some(property));
        }
        for number in [0, 259, 511, 517, 1023, 1280, u32::MAX] {
            assert_eq!(Property::of_which_number(number), None);
        }
        assert_eq!(Property::Concept(1).which_number(), 0);
    }
}
