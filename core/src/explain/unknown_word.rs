//! A word that the model does not know by itself: what it means among others, or which one is like it.

use core::fmt;

use crate::language::{nearest_word, said_around, said_between, said_of_two, unit_of};
use crate::model::Model;

/// What is known of an unknown word.
pub(super) enum UnknownWord<'a> {
    /// Nothing is like it.
    Strange,
    /// A word of the model is like it.
    Like(&'a str),
    /// It stands around the objects of a list: what is said before and behind them.
    AroundList(&'a str, &'a str),
    /// It stands between two descriptions, in this text.
    BetweenDescriptions(&'a str),
    /// Two objects stand behind it, in this text: "between".
    OfTwo(&'a str),
    /// It is a unit of length; and how a person says where a side is.
    Unit(&'a str, &'a str),
}

impl<'a> UnknownWord<'a> {
    pub(super) fn of(model: &Model<'a>, word: &str) -> Self {
        if let Some((before, behind)) = said_around(model, word) {
            Self::AroundList(before, behind)
        } else if let Some(text) = said_between(model, word) {
            Self::BetweenDescriptions(text)
        } else if let Some(text) = said_of_two(model, word) {
            Self::OfTwo(text)
        } else if let Some((unit, side)) = unit_of(model, word) {
            Self::Unit(unit, side)
        } else {
            nearest_word(model, word).map_or(Self::Strange, Self::Like)
        }
    }

    /// Writes what is said of the word.
    pub(super) fn write(&self, word: impl fmt::Display, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Strange => write!(
                f,
                "{word} is not a word that the model knows; use another one"
            ),
            Self::Like(known) => write!(
                f,
                "{word} is not a word that the model knows; did you mean \"{known}\"?"
            ),
            Self::AroundList(before, behind) => {
                let space = if behind.is_empty() { "" } else { " " };
                write!(
                    f,
                    "{word} is only understood around a list of objects, as in \
                     \"{before} …{space}{behind}\"; list each object by itself, and nothing else"
                )
            }
            Self::BetweenDescriptions(text) => write!(
                f,
                "{word} is only understood between two descriptions, as in \"the … {text} the …\", \
                 with the same words before both; say only what you mean"
            ),
            Self::OfTwo(text) => write!(
                f,
                "{word} is only understood with two objects behind it, as in \
                 \"{text} the … and the …\"; name both"
            ),
            Self::Unit(unit, side) => write!(
                f,
                "{word} is only understood in a distance from another object, as in \
                 \"2 {unit} {side} the …\"; say only how far apart the two should be"
            ),
        }
    }
}
