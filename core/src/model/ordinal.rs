use crate::dsl::Extreme;

/// What is counted from an extreme, "the second red block from the left": texts that mean it. Nothing is
/// learned for them. By default, nothing can be counted.
///
/// All texts are words in lower case with one space in between; they need not be among
/// [`Model::words`](super::Model::words).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Ordinals<'a> {
    /// What can be meant, except the extremes themselves.
    pub ranked: &'a [Ranked<'a>],
    /// Words that count; sorted by text.
    pub counts: &'a [Count<'a>],
    /// From where is counted; sorted by text.
    pub from: &'a [CountedFrom<'a>],
    /// The first word of each text that means the extreme itself where nothing is counted; sorted.
    pub first_words: &'a [&'a str],
    /// Words that stand before a count where a noun is left out, "the" in "the second from the left"; sorted.
    pub articles: &'a [&'a str],
    /// Words that may stand between a description and from where is counted, "block"; sorted.
    pub nouns: &'a [&'a str],
    /// Words behind "from the left" with which it means something else, "of"; sorted.
    pub unless: &'a [&'a str],
}

/// Which of the objects that fit, counted from an extreme.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Ranked<'a> {
    /// The name, in programs and for people: "second leftmost".
    pub name: &'a str,
    /// From where it is counted.
    pub extreme: Extreme,
    /// The number of the object, from 2: the first is the extreme itself.
    pub rank: u8,
}

/// A word that counts.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Count<'a> {
    /// The word, "second".
    pub text: &'a str,
    /// The number, from 1.
    pub rank: u8,
}

/// Words that say from where is counted.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct CountedFrom<'a> {
    /// The words, "from the left", or, if nothing need be counted, "on the far left".
    pub text: &'a str,
    /// What is counted from.
    pub extreme: Extreme,
    /// Whether they mean the extreme itself where nothing is counted.
    pub is_first: bool,
}

impl<'a> Ordinals<'a> {
    /// Whether anything can be counted.
    pub(crate) const fn is_empty(&self) -> bool {
        self.from.is_empty()
    }
}
