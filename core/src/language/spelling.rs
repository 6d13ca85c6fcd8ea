//! Unknown words that are read as known ones: misspelt, or mistaken by dictation.

use heapless::Vec;

use super::Span;
use super::nearest::{is_one_edit, letters};
use crate::model::Model;

/// The most known words that an unknown one may stand for.
pub(super) const MAX_ALTERNATIVES: usize = 4;
/// Letters of the shortest words that are read as others, and as which others are read.
const LEAST_LETTERS: usize = 3;

/// A known word; an index into one of the model's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KnownWord {
    /// Into [`Model::words`].
    Word(u16),
    /// Into [`Model::lexicon`].
    Concept(u16),
}

/// An unknown word that was read as a known one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Correction {
    span: Span,
    word: KnownWord,
}

impl Correction {
    pub(super) const fn new(span: Span, word: KnownWord) -> Self {
        Self { span, word }
    }

    /// The unknown word's place in the sentence.
    pub const fn span(&self) -> Span {
        self.span
    }

    /// The known word; empty only with a model that did not read the sentence.
    pub fn read_as<'a>(&self, model: &Model<'a>) -> &'a str {
        match self.word {
            KnownWord::Word(index) => model.words.get(usize::from(index)).map(|word| word.text),
            KnownWord::Concept(index) => {
                let entry = model.lexicon.get(usize::from(index));
                entry.map(|entry| entry.text)
            }
        }
        .unwrap_or_default()
    }
}

/// The known words that an unknown one may stand for; none if there are too many.
pub(super) type Alternatives = Vec<KnownWord, MAX_ALTERNATIVES, u8>;

/// The known words that an unknown one may stand for: the one that it is
/// [heard](crate::model::Spelling::heard) as, or else all those of three letters and more that one
/// letter omitted, added, changed or swapped with its neighbour turns it into. None if it is
/// [another word](crate::model::Spelling::other_words), is too short, or contains anything but
/// letters.
///
/// Cost: a few comparisons for each letter of each word of the model.
pub(super) fn alternatives(model: &Model<'_>, word: &str) -> Alternatives {
    let mut found = Alternatives::new();
    let Some(letters) = letters(word) else {
        return found;
    };
    let spelling = &model.spelling;
    let heard = spelling.heard.binary_search_by(|heard| {
        let text = heard.text.chars();
        text.cmp(letters.iter().copied())
    });
    if let Some(heard) = heard.ok().and_then(|index| spelling.heard.get(index)) {
        for (known, text) in known_words(model) {
            if text == heard.read_as {
                let _ = found.push(known);
            }
        }
        return found;
    }
    if spelling.other_words.is_empty()
        || letters.len() < LEAST_LETTERS
        || !letters.iter().all(|letter| letter.is_alphabetic())
        || spelling.other_words.binary_search(&word_hash(word)).is_ok()
    {
        return found;
    }
    for (known, text) in known_words(model) {
        let Some(text) = self::letters(text) else {
            continue;
        };
        if text.len() >= LEAST_LETTERS && is_one_edit(&letters, &text) && found.push(known).is_err()
        {
            return Alternatives::new();
        }
    }
    found
}

fn known_words<'a>(model: &Model<'a>) -> impl Iterator<Item = (KnownWord, &'a str)> {
    // There are no more than a u16 can count: the model was checked.
    let words = model.words.iter().zip(0..);
    let concepts = model.lexicon.iter().zip(0..);
    words
        .map(|(word, index)| (KnownWord::Word(index), word.text))
        .chain(concepts.map(|(entry, index)| (KnownWord::Concept(index), entry.text)))
}

/// The hash of a word in [`crate::model::Spelling::other_words`].
pub fn word_hash(word: &str) -> u16 {
    let mut hash = 0x811c_9dc5_u32;
    for letter in word.chars().flat_map(char::to_lowercase) {
        let mut bytes = [0; 4];
        for &byte in letter.encode_utf8(&mut bytes).as_bytes() {
            hash = (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
    // Both halves fit.
    ((hash >> 16) ^ (hash & 0xffff)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::model::{Heard, Spelling};

    fn texts(model: &Model<'_>, word: &str) -> std::vec::Vec<std::string::String> {
        let found = alternatives(model, word);
        let correction = |&known| Correction::new(Span::default(), known);
        let texts = found.iter().map(correction);
        texts.map(|each| each.read_as(model).into()).collect()
    }

    #[test]
    fn hashes_are_those_of_fnv() {
        // The 32-bit hashes of "a" and "foobar" are e40c292c and bf9cf968.
        assert_eq!(word_hash("a"), 0xe40c ^ 0x292c);
        assert_eq!(word_hash("foobar"), 0xbf9c ^ 0xf968);
        assert_eq!(word_hash("FooBar"), word_hash("foobar"));
    }

    #[test]
    fn a_misspelt_word_may_stand_for_all_words_that_are_one_edit_away() {
        let mut model = fixture::model();
        // Nothing is misspelt in a model that does not know which words are not.
        assert!(texts(&model, "gren").is_empty());
        let mut others = [word_hash("rod"), word_hash("lest")];
        others.sort_unstable();
        let heard = [Heard::new().with_text("read").with_read_as("red")];
        model.spelling = Spelling::new().with_other_words(&others).with_heard(&heard);
        for (word, expected) in [
            ("gren", &["green"][..]),
            ("GRENE", &["green"]),
            ("smal", &["small"]),
            ("teh", &["the"]),
            ("thn", &["the", "then"]),
            // Another English word.
            ("rod", &[]),
            ("lest", &[]),
            ("Read", &["red"]),
            ("rd", &[]),
            ("red2", &[]),
            ("gr-een", &[]),
            ("greeeen", &[]),
            ("", &[]),
        ] {
            let mut found = texts(&model, word);
            found.sort();
            assert_eq!(found, expected, "{word}");
        }
        assert!(texts(&model, &"red".repeat(1000)).is_empty());
    }
}
