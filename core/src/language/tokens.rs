//! The tokens of a sentence, and what several of them say together.

use heapless::Vec;

use super::{Correction, Span};
use crate::capacity::{MAX_CORRECTIONS, MAX_FILTERS, MAX_TOKENS};
use crate::dsl::{Filters, Property};
use crate::model::{Model, WordEmbeddings};
use crate::refusal::Refusal;

/// The kind of a token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TokenKind {
    /// A word outside the lexicon: index into [`Model::words`].
    Word(u16),
    /// Adjacent words of the lexicon, `[[X]]` in the paper.
    Group(Filters),
    /// A pronoun that is read as a group: it stands for what the step before moved.
    Pronoun,
    /// An unknown word, which only what is said of a tower or a row may have.
    Unknown,
    /// The last of the words that are read where a compound was said.
    Compound {
        /// That word: index into [`Model::words`].
        word: u16,
        /// Index as of [`Model::compound`].
        compound: u8,
    },
}

/// A token with its place in the sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Token {
    /// Its kind.
    pub kind: TokenKind,
    /// Its place.
    pub span: Span,
}

impl Token {
    /// Its embeddings; `None` only for an unknown word and a token of another model.
    pub fn embeddings(&self, model: &Model<'_>) -> Option<WordEmbeddings> {
        model.embeddings.get(self.embedding()?)
    }

    /// Its index in [`Model::embeddings`]; `None` for an unknown word.
    pub const fn embedding(&self) -> Option<usize> {
        match self.kind {
            TokenKind::Word(word) | TokenKind::Compound { word, .. } => {
                Some((word as usize).saturating_add(1))
            }
            TokenKind::Group(_) | TokenKind::Pronoun => Some(0),
            TokenKind::Unknown => None,
        }
    }

    /// Whether it describes an object: a group or a pronoun.
    pub const fn is_group(&self) -> bool {
        matches!(self.kind, TokenKind::Group(_) | TokenKind::Pronoun)
    }

    /// The concepts, if it is a group.
    pub const fn filters(&self) -> Option<&Filters> {
        match &self.kind {
            TokenKind::Group(filters) => Some(filters),
            _ => None,
        }
    }
}

/// The unknown words of a sentence that were read as known ones.
pub type Corrections = Vec<Correction, MAX_CORRECTIONS, u8>;

/// The tokens of a sentence.
pub type Tokens = Vec<Token, MAX_TOKENS, u8>;

/// What was left out of the tokens, and belongs to a description.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    /// Where that description begins in the sentence.
    pub(super) at: u16,
    /// What an object looks like that is not meant, or that is a further reference.
    pub(super) filters: Filters,
    pub(super) kind: KeptKind,
}

/// What was left out of the tokens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum KeptKind {
    /// Objects that are not meant: "except the red one".
    Exception,
    /// The second of two: "between the red and the blue one".
    Second,
}

impl Kept {
    /// Whether it belongs to the description in this place.
    pub(super) const fn is_of(&self, span: Span) -> bool {
        span.start <= self.at && self.at < span.end
    }
}

/// One group for what two say of an object.
pub(super) fn join(model: &Model<'_>, first: &Token, second: &Token) -> Result<Token, Refusal> {
    let (mut filters, more) = match (first.filters(), second.filters()) {
        (Some(first), Some(second)) => (*first, second),
        _ => return Err(Refusal::InvalidModel),
    };
    let span = Span {
        start: first.span.start,
        end: second.span.end,
    };
    for concept in more.concepts() {
        add_value(model, &mut filters, Property::Concept(*concept), span)?;
    }
    Ok(Token {
        kind: TokenKind::Group(filters),
        span,
    })
}

/// A group says more of an object. Values of one attribute exclude each other, so that no object has two;
/// and so do extremes and quantifiers.
///
/// * `span`: the place of the group
pub(super) fn add_value(
    model: &Model<'_>,
    filters: &mut Filters,
    property: Property,
    span: Span,
) -> Result<(), Refusal> {
    if let Some(first) = conflicting(model, filters, property) {
        return Err(Refusal::ConflictingValues {
            span,
            first,
            second: property,
        });
    }
    filters.add(property).map_err(|_| Refusal::TooManyConcepts {
        span,
        limit: MAX_FILTERS as u8,
    })
}

/// The place of these tokens in the sentence; `None` if there are none.
pub(super) fn span_of(tokens: &[Token]) -> Option<Span> {
    Some(Span {
        start: tokens.first()?.span.start,
        end: tokens.last()?.span.end,
    })
}

/// Refuses words that may mean several things.
pub(super) fn unclear(model: &Model<'_>, span: Span) -> Refusal {
    Refusal::UnclearWords {
        step: 0,
        span,
        probability: 0.5,
        threshold: model.header.thresholds.decision,
    }
}

/// Appends a token, as far as there is room.
pub(super) fn push(tokens: &mut Tokens, kind: TokenKind, span: Span) -> Result<(), Refusal> {
    tokens
        .push(Token { kind, span })
        .map_err(|_| Refusal::SentenceTooLong {
            limit: MAX_TOKENS as u16,
            unit: crate::refusal::LengthUnit::Tokens,
        })
}

/// What a group says that excludes a further property.
fn conflicting(model: &Model<'_>, filters: &Filters, property: Property) -> Option<Property> {
    if filters.is_table() {
        return filters.choice();
    }
    match property {
        Property::Concept(concept) => {
            let attribute_of = |concept: u8| {
                let found = model.concepts.get(usize::from(concept));
                found.map(|concept| concept.attribute)
            };
            let conflicts =
                |&other: &u8| other != concept && attribute_of(other) == attribute_of(concept);
            let mut concepts = filters.concepts().iter().copied();
            concepts.find(conflicts).map(Property::Concept)
        }
        Property::Extreme(_) | Property::Ranked(_) | Property::Quantifier(_) => {
            filters.choice().filter(|other| *other != property)
        }
        // The table is described by no other word, and neither is the object itself.
        Property::Table | Property::Itself => {
            let first = filters.concepts().first();
            let first = first.map(|concept| Property::Concept(*concept));
            first.or(filters.choice())
        }
    }
}
