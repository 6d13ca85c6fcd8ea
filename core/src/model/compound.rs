use super::Model;

/// Actions of which a [`Compound`] of the kind [`CompoundKind::All`] is made.
pub const COMPOSED: usize = 2;

/// Actions that are made of others: "next to" puts an object where any of several actions would, "in front and
/// to the left of" where two do together, "between" halfway between two. Nothing is learned for them.
///
/// All texts are words in lower case with one space in between. What is read in place of others is among
/// [`Model::words`]; the others need not be.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Compounds<'a> {
    /// What is meant.
    pub compounds: &'a [Compound<'a>],
    /// What means it; sorted by text.
    pub said: &'a [CompoundText<'a>],
    /// The first word of each of these texts; sorted.
    pub first_words: &'a [&'a str],
    /// Words that name a side, "left"; sorted. Near one, no compound of the kind [`CompoundKind::Any`] is meant:
    /// "next to the blue block, on its left" is what the network knows.
    pub sides: &'a [&'a str],
}

/// An action that is made of others.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Compound<'a> {
    /// The name in programs, `MoveNextTo`.
    pub name: &'a str,
    /// How a person says it, "next to".
    pub phrase: &'a str,
    /// How its parts make it up.
    pub kind: CompoundKind,
    /// Indices into [`Model::actions`]: at most [`MAX_SIDES`](super::MAX_SIDES), of
    /// [`CompoundKind::All`] [`COMPOSED`], of [`CompoundKind::Between`] one.
    pub parts: &'a [u8],
    /// As what it is read, as which the network knows the first of the parts: "to the right of".
    pub read: &'a str,
}

/// Words that mean a compound.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct CompoundText<'a> {
    /// The words, "close to".
    pub text: &'a str,
    /// The compound: index into [`Compounds::compounds`].
    pub compound: u8,
}

/// How the parts of a [`Compound`] make it up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CompoundKind {
    /// One of them, whichever leads to a free place.
    Any,
    /// All of them, one after the other.
    All,
    /// Halfway between two references. The only part says how far an object is from another one that it stands beside.
    Between,
}

impl<'a> Model<'a> {
    /// The compound with this index, which follow those of [`Model::actions`]; `None` for an action, and
    /// for none.
    pub fn compound(&self, index: u8) -> Option<&'a Compound<'a>> {
        let index = usize::from(index).checked_sub(self.actions.len())?;
        self.compounds.compounds.get(index)
    }

    /// The name of an action or a compound; `None` if there is none.
    pub fn action_name(&self, index: u8) -> Option<&'a str> {
        match self.actions.get(usize::from(index)) {
            Some(action) => Some(action.name),
            None => self.compound(index).map(|compound| compound.name),
        }
    }

    /// Whether an action or a relation is between two others.
    pub(crate) fn is_between(&self, action: u8) -> bool {
        self.compound(action)
            .is_some_and(|compound| compound.kind == CompoundKind::Between)
    }

    /// Whether an action puts an object beside another one, to a single side or to any.
    pub(crate) fn puts_aside(&self, action: u8) -> bool {
        match self.compound(action) {
            Some(compound) => compound.kind == CompoundKind::Any,
            None => self.distances.sides.contains(&action),
        }
    }

    /// The first of the parts of a compound, as which it is read; an action is its own.
    pub(crate) fn read_action(&self, index: u8) -> Option<u8> {
        match self.compound(index) {
            Some(compound) => compound.parts.first().copied(),
            None => Some(index),
        }
    }
}
