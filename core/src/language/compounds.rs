//! Actions that are made of others: "next to the blue block", "in front and to the left of it".
//!
//! The words are replaced by those of the first part, "to the right of", which the network reads and
//! judges as if they had been said; the last of them is marked, and where it is read as the step's action
//! or as a relation, the compound is meant. Nothing is learned here: the model lists what is said and how
//! it is read ([`crate::model::Compound`]).

use core::ops::Range;

use super::lists::{Pair, single};
use super::phrases::{PhraseMatcher, parts};
use super::tokens::{Kept, Tokens, span_of};
use super::words::{find, letters};
use super::{Span, Token, TokenKind};
use crate::dsl::Quantifier;
use crate::model::{Compound, CompoundKind, CompoundText, Compounds, Model};
use crate::refusal::Refusal;

/// The words of a compound among the tokens.
pub(super) struct Meant<'a> {
    said: Range<usize>,
    /// Index as of [`crate::Model::compound`].
    index: u8,
    compound: &'a Compound<'a>,
    /// Whether they mean nothing else: one of them is unknown.
    pub(super) is_sure: bool,
    /// Behind "between", the two that follow.
    pair: Option<Pair>,
}

impl Meant<'_> {
    /// Whether two objects follow, between which something is.
    pub(super) const fn is_pair(&self) -> bool {
        self.pair.is_some()
    }

    /// Index of the token behind them.
    pub(super) const fn behind(&self) -> usize {
        self.said.end
    }
}

impl<'a> PhraseMatcher<'_, 'a> {
    /// What means a compound and begins at a token: of several, the one with the most words.
    pub(super) fn compound(&self, tokens: &[Token], at: usize) -> Option<Meant<'a>> {
        let rest = tokens.get(at..)?;
        let first = rest.first()?;
        if !self.is_one_of(self.model.compounds.first_words, first) {
            return None;
        }
        let (length, text) = self.longest(rest, self.model.compounds.said)?;
        let index = usize::from(text.compound);
        let said = at..at.checked_add(length)?;
        if self.begins_distance(tokens.get(said.end..)?) {
            return None;
        }
        let compound = self.model.compounds.compounds.get(index)?;
        if compound.kind == CompoundKind::Any && self.names_side(tokens, &said) {
            return None;
        }
        let pair = match compound.kind {
            CompoundKind::Between if self.names_both(tokens, said.end) => None,
            CompoundKind::Between => Some(self.pair(tokens, said.end)?),
            _ => None,
        };
        let mut words = tokens.get(said.clone())?.iter();
        Some(Meant {
            pair,
            said,
            index: u8::try_from(self.model.actions.len().checked_add(index)?).ok()?,
            compound,
            is_sure: words.any(|token| token.kind == TokenKind::Unknown),
        })
    }

    /// Whether two objects that look alike are described at a token, "both red ones" or "the two red ones".
    fn names_both(&self, tokens: &[Token], at: usize) -> bool {
        let articles = self.model.ordinals.articles;
        let has_article = tokens
            .get(at)
            .is_some_and(|token| self.is_one_of(articles, token));
        let group = at.saturating_add(usize::from(has_article));
        let filters = tokens.get(group).and_then(Token::filters);
        let is_both = filters.is_some_and(|group| group.quantifier() == Some(Quantifier::Both));
        // "Between both the red and the blue one".
        is_both && self.pair(tokens, at).is_none()
    }

    /// Whether a side is named near these words: from the description before them to the first one behind that
    /// is of another clause.
    fn names_side(&self, tokens: &[Token], said: &Range<usize>) -> bool {
        // Not to a pronoun: its word may be another one.
        let describes = |token: &Token| token.filters().is_some();
        let before = tokens.get(..said.start).unwrap_or_default().iter().rev();
        let before = before.take_while(|token| !describes(token));
        let (mut is_described, mut has_ended) = (false, false);
        let behind = tokens.get(said.end..).unwrap_or_default().iter();
        let behind = behind.take_while(|token| {
            has_ended |= is_described && self.is_one_of(self.model.arrangements.ends, token);
            is_described |= describes(token);
            !(has_ended && describes(token))
        });
        let mut near = before.chain(behind);
        near.any(|token| self.is_one_of(self.model.compounds.sides, token))
    }

    /// The compound that a text means which stands before a token, and its index, unless a side is named near it.
    pub(super) fn beside(
        &self,
        tokens: &[Token],
        at: usize,
        text: &str,
    ) -> Option<(&'a Compound<'a>, u8)> {
        let (_, said) = find(self.model.compounds.said, text, |said| said.text)?;
        if self.names_side(tokens, &(at..at)) {
            return None;
        }
        let index = usize::from(said.compound);
        let compound = self.model.compounds.compounds.get(index)?;
        let index = self.model.actions.len().checked_add(index)?;
        Some((compound, u8::try_from(index).ok()?))
    }

    /// Replaces these words, and leaves the second of two out; the index of the token behind, and what is kept of it.
    pub(super) fn replace_compound(
        &self,
        tokens: &mut Tokens,
        meant: &Meant<'a>,
    ) -> Result<(usize, Option<Kept>), Refusal> {
        if let Some(pair) = &meant.pair {
            if let Some(first) = tokens.get_mut(pair.first) {
                first.kind = single(first);
            }
            let span = Span::default();
            self.replace(tokens, &pair.second, "", span)?;
        }
        let Meant {
            said,
            index,
            compound,
            ..
        } = meant;
        let words = tokens.get(said.clone()).unwrap_or_default();
        let span = span_of(words).ok_or(Refusal::InvalidModel)?;
        let behind = self.replace(tokens, said, compound.read, span)?;
        mark(tokens, behind, *index);
        Ok((behind, meant.pair.as_ref().map(|pair| pair.kept)))
    }
}

/// Marks the last of the words as which a compound is read.
///
/// * `behind`: index of the token behind them
pub(super) fn mark(tokens: &mut Tokens, behind: usize, compound: u8) {
    let last = behind.checked_sub(1).and_then(|last| tokens.get_mut(last));
    if let Some(token) = last
        && let TokenKind::Word(word) = token.kind
    {
        token.kind = TokenKind::Compound { word, compound };
    }
}

/// The compounds that were said before a step's group: since the group before it.
///
/// * `tokens`: those of the step
/// * `group`: how many groups stand before it
pub(super) fn before_group(tokens: &[Token], group: usize) -> impl Iterator<Item = u8> + Clone {
    let mut passed = 0_usize;
    let between = tokens.iter().map(move |token| {
        if token.is_group() {
            passed = passed.saturating_add(1);
        }
        (passed, token)
    });
    between.filter_map(move |(passed, token)| match token.kind {
        TokenKind::Compound { compound, .. } if passed == group => Some(compound),
        _ => None,
    })
}

/// How a person says that something is between two objects, if this is one of the words for it.
pub(crate) fn said_of_two<'a>(model: &Model<'a>, word: &str) -> Option<&'a str> {
    let Compounds {
        compounds, said, ..
    } = model.compounds;
    let has = |text: &str| parts(text).any(|part| letters(word).eq(part.chars()));
    let mut meant = said.iter().filter(|said| has(said.text));
    let of_two = |said: &CompoundText<'a>| {
        let compound = compounds.get(usize::from(said.compound))?;
        (compound.kind == CompoundKind::Between).then_some(compound.phrase)
    };
    meant.find_map(of_two)
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use crate::fixture::{self, parse};
    use crate::model::CompoundText;

    /// How a sentence is understood, with shorter names.
    fn read(sentence: &str) -> String {
        fixture::read(&fixture::with_compounds(), sentence)
            .replace("Unique(Filter(", "(")
            .replace(", Scene()))", ")")
    }

    #[test]
    fn a_compound_is_the_action_or_the_relation_as_which_its_words_are_read() {
        for (sentence, expected) in [
            ("put red by green", "Action(NextTo, (red), (green))"),
            ("put red close to green", "Action(NextTo, (red), (green))"),
            (
                "put red diagonally green",
                "Action(RightOn, (red), (green))",
            ),
            // The longest text that fits.
            (
                "put red by the green on lego",
                "Action(MoveOn, (red, Relate(IsNextTo, (green)))), (lego))",
            ),
            (
                "put red on what is by lego",
                "Action(MoveOn, (red), Unique(Relate(StandsFor, (lego))))",
            ),
            (
                "put red by what is by lego",
                "Action(NextTo, (red), Unique(Relate(StandsFor, (lego))))",
            ),
            (
                "put red on green then put lego by red",
                "Action(MoveOn, (red), (green))\nAction(NextTo, (lego), (red))",
            ),
        ] {
            assert_eq!(read(sentence), expected, "{sentence}");
        }
    }

    #[test]
    fn where_all_words_are_known_both_readings_must_agree() {
        // As such, it says nothing of what is done with the red one.
        assert_eq!(read("put red past green"), "Action(NextTo, (red), (green))");
        let mut model = fixture::with_compounds();
        let said = [CompoundText {
            text: "right",
            compound: 0,
        }];
        model.compounds.said = &said;
        model.compounds.first_words = &["right"];
        let refusal = parse(&model, "put red right green").unwrap_err();
        assert_eq!(refusal.kind(), "unclear_words");
    }

    #[test]
    fn a_compound_that_is_neither_is_refused() {
        for sentence in [
            // Before the object to be moved.
            "put by red on green",
            "put by red right green",
            // Of two, only one is the action.
            "put red by by green",
            "put red by green right",
            "put red by past lego",
        ] {
            let kind = read(sentence);
            assert!(
                matches!(&*kind, "unclear_words" | "unsure"),
                "{sentence}: {kind}"
            );
        }
    }

    #[test]
    fn where_a_side_is_named_no_compound_is_meant() {
        for sentence in [
            "put red by green leftwards",
            "put red leftwards by green",
            "put red close to green the perhaps",
            "put red close to the perhaps green",
            "put red close to green beside lego perhaps",
            "put red close to green , lego perhaps",
        ] {
            assert_eq!(read(sentence), "unknown_word", "{sentence}");
        }
        // In another step.
        let two = read("put red by green then put lego on red the perhaps");
        assert!(two.starts_with("Action(NextTo, (red), (green))\n"), "{two}");
    }

    #[test]
    fn what_is_unknown_and_means_no_compound_stays_unknown() {
        for sentence in ["put red close green", "put red on green close to"] {
            let kind = read(sentence);
            assert!(
                matches!(&*kind, "unknown_word" | "unsure"),
                "{sentence}: {kind}"
            );
        }
    }
}
