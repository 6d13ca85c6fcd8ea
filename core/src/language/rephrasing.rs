//! Phrases that are read as others which mean the same: "so that it is on the blue block" as "so that it's on …".
//!
//! The network judges the sentence with the other words as if they had been said. Nothing is learned here:
//! the model lists what is said and how it is read ([`crate::model::Rephrasing`]).

use core::ops::Range;

use super::Token;
use super::phrases::PhraseMatcher;
use crate::model::Rephrasing;

impl<'a> PhraseMatcher<'_, 'a> {
    /// The phrase of a list that begins at a token, of several the longest, and what is read in its place.
    pub(super) fn rephrased(
        &self,
        rephrasing: &Rephrasing<'a>,
        tokens: &[Token],
        at: usize,
    ) -> Option<(Range<usize>, &'a str)> {
        let rest = tokens.get(at..)?;
        if !self.is_one_of(rephrasing.first_words, rest.first()?) {
            return None;
        }
        let (length, phrase) = self.longest(rest, rephrasing.said)?;
        Some((at..at.checked_add(length)?, phrase.read_as))
    }
}

#[cfg(test)]
mod tests {
    use crate::fixture::{self, parse};
    use crate::model::{Rephrased, Rephrasing};

    #[test]
    fn a_phrase_is_read_as_another_one() {
        let said = [
            ("belongs lego near", "right"),
            ("belongs near", "right"),
            ("put down", "put"),
            ("put scarlet", "put red"),
            ("then", ", then"),
        ];
        let said = said.map(|(text, read_as)| Rephrased { text, read_as });
        let mut model = fixture::with_compounds();
        model.rephrasing = Rephrasing {
            said: &said,
            first_words: &["belongs", "put", "then"],
        };
        assert_eq!(model.check(), Ok(()));
        for (sentence, same) in [
            // With a word that describes an object.
            ("put scarlet right green", "put red right green"),
            ("put red belongs lego near green", "put red right green"),
            ("put red belongs near green", "put red right green"),
            ("put DOWN red right green", "put red right green"),
            (
                "put down red belongs near green then put down lego on red",
                "put red right green , then put lego on red",
            ),
        ] {
            let expected = parse(&model, same).unwrap();
            assert_eq!(parse(&model, sentence), Ok(expected), "{sentence}");
        }
        // Only as a whole.
        for sentence in ["put red belongs green", "put red belongs right green"] {
            let refusal = parse(&model, sentence).unwrap_err();
            assert_eq!(refusal.kind(), "unknown_word", "{sentence}");
        }
    }
}
