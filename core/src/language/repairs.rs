//! What a speaker takes back or rules out: "the red block, no, the green one", "the red block instead of the
//! green one".
//!
//! The description that is not meant is left out before the network reads the sentence: "the green one". The
//! words before it must be said again, "on the blue one, no, on the white one", so that it is known which
//! description is meant. Nothing is learned here: the model lists the words ([`crate::model::Repairs`]).

use core::ops::Range;

use super::phrases::{PhraseMatcher, parts};
use super::tokens::{Tokens, push};
use super::words::letters;
use super::{Token, TokenKind};
use crate::capacity::ARGUMENTS;
use crate::dsl::Filters;
use crate::model::{Model, Repairs};
use crate::refusal::Refusal;

/// Words that say that one of two descriptions is not meant.
#[derive(Debug)]
pub(super) struct Repair {
    /// The tokens that are left out: the first description with the words that are said again before the
    /// second one, and those in between.
    left_out: Range<usize>,
    /// Index of the second description.
    second: usize,
    /// Index of the description that is meant, the first or the second.
    meant: usize,
}

impl Repair {
    /// Index of the token behind both descriptions, once the words are left out.
    pub(super) fn behind(&self) -> usize {
        let second = self.second.saturating_sub(self.left_out.len());
        second.saturating_add(1)
    }

    /// The tokens with the description that is meant alone.
    pub(super) fn repaired(&self, tokens: &[Token]) -> Result<Tokens, Refusal> {
        let meant = tokens.get(self.meant).ok_or(Refusal::InvalidModel)?;
        let mut repaired = Tokens::new();
        for (index, token) in tokens.iter().enumerate() {
            if index == self.second {
                push(&mut repaired, meant.kind, meant.span)?;
            } else if !self.left_out.contains(&index) {
                push(&mut repaired, token.kind, token.span)?;
            }
        }
        Ok(repaired)
    }
}

impl PhraseMatcher<'_, '_> {
    /// What is taken back or ruled out by the words at a token. A description is only taken back if a single one
    /// before it can be meant, and if all that it says is said anew.
    pub(super) fn repair(&self, tokens: &[Token], at: usize) -> Option<Repair> {
        let repairs = self.model.repairs;
        let rest = tokens.get(at..)?;
        let longest = |texts| {
            let found = self.longest::<&str>(rest, texts);
            found.map_or(0, |(length, _)| length)
        };
        let (correction, exclusion) = (longest(repairs.corrections), longest(repairs.exclusions));
        let said = rest.get(..correction.max(exclusion))?;
        // Others have a meaning of their own.
        said.iter().find(|token| token.kind == TokenKind::Unknown)?;
        let said = at..at.checked_add(said.len())?;
        let behind = self.behind_comma(tokens, said.end);
        let second = tokens.get(behind..)?.iter().position(Token::is_group)?;
        let second = behind.checked_add(second)?;
        let first = self.taken_back(tokens, at)?;
        let again = tokens.get(behind..second)?;
        let from = said_before(tokens, first, again)?;
        let clause = self.clause(tokens, &said)?;
        let filters = |index: usize| tokens.get(index)?.filters();
        let is_correction = correction > exclusion;
        if is_correction {
            let mut others = clause.start..first;
            let fits_too = |other: usize| {
                filters(other).is_some() && said_before(tokens, other, again).is_some()
            };
            let says_as_much = says_as_much(self.model, filters(first)?, filters(second)?);
            if others.any(fits_too) || !says_as_much {
                return None;
            }
        } else {
            // "All small blocks, not red ones" rules nothing out, and leaves some out.
            let (meant, other) = (filters(first)?, filters(second)?);
            let mut said = other.concepts().iter();
            let is_same = said.all(|concept| meant.concepts().contains(concept));
            if is_same || !says_as_much(self.model, other, meant) {
                return None;
            }
            // What else is described may belong to the one that is left out.
            let groups = tokens.get(clause)?.iter().filter(|token| token.is_group());
            if groups.count() > ARGUMENTS.saturating_add(1) {
                return None;
            }
        }
        Some(Repair {
            left_out: from..second.checked_sub(again.len())?,
            second,
            meant: if is_correction { second } else { first },
        })
    }

    /// Index of the description before a token: directly before it, or before a noun and a comma.
    fn taken_back(&self, tokens: &[Token], at: usize) -> Option<usize> {
        let before = |at: usize| at.checked_sub(1).and_then(|last| tokens.get(last));
        let end = at.checked_sub(usize::from(self.is_comma(before(at)?)))?;
        let is_noun = matches!(before(end)?.kind, TokenKind::Word(_));
        let last = end.checked_sub(1)?.checked_sub(usize::from(is_noun))?;
        tokens.get(last)?.filters().map(|_| last)
    }
}

/// How a word is said by which something is taken back or ruled out: the shortest text that has it.
pub(crate) fn said_between<'a>(model: &Model<'a>, word: &str) -> Option<&'a str> {
    let Repairs {
        corrections,
        exclusions,
    } = model.repairs;
    let texts = corrections.iter().chain(exclusions).copied();
    texts
        .filter(|text| parts(text).any(|part| letters(word).eq(part.chars())))
        .min_by_key(|text| text.len())
}

/// Where these words begin that stand directly before a description.
fn said_before(tokens: &[Token], description: usize, words: &[Token]) -> Option<usize> {
    let from = description.checked_sub(words.len())?;
    let before = tokens.get(from..description)?;
    let is_same = before
        .iter()
        .zip(words)
        .all(|(one, other)| one.kind == other.kind);
    is_same.then_some(from)
}

/// Whether a description says something in place of all that another one says.
fn says_as_much(model: &Model<'_>, first: &Filters, second: &Filters) -> bool {
    if first.is_table() || second.is_table() {
        return true;
    }
    let attribute = |concept: &u8| {
        model
            .concepts
            .get(usize::from(*concept))
            .map(|one| one.attribute)
    };
    let is_said = |concept: &u8| {
        second
            .concepts()
            .iter()
            .any(|other| attribute(other) == attribute(concept))
    };
    let (one, other) = (first.choice(), second.choice());
    first.concepts().iter().all(is_said) && (one.is_none() || other.is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    fn parse(sentence: &str) -> Result<std::string::String, Refusal> {
        let repairs = Repairs::new()
            .with_corrections(&["no", "no wait"])
            .with_exclusions(&["instead of", "near", "never"]);
        let model = fixture::with_table().with_repairs(repairs);
        assert_eq!(model.check(), Ok(()));
        fixture::parse(&model, sentence)
    }

    #[test]
    fn what_is_not_meant_is_left_out() {
        for (sentence, meant) in [
            ("put red no green on lego", "put green on lego"),
            (
                "put the red , no wait , the green on lego",
                "put the green on lego",
            ),
            (
                "put the red the no the green the on lego",
                "put the green the on lego",
            ),
            ("put red no green small on lego", "put green small on lego"),
            ("put lego on red no on green", "put lego on green"),
            (
                "put lego on the green , no , on the desk",
                "put lego on the desk",
            ),
            (
                "put topmost red no rightmost green on lego",
                "put rightmost green on lego",
            ),
            ("put small never lego on green", "put small on green"),
            (
                "put red small the instead of lego the on green",
                "put red small the on green",
            ),
            (
                "put lego on the green never on the red",
                "put lego on the green",
            ),
            (
                "put small never lego on green then put lego no small on red",
                "put small on green then put small on red",
            ),
            (
                "put lego on red then put lego on red no on green",
                "put lego on red then put lego on green",
            ),
        ] {
            assert_eq!(parse(sentence), parse(meant), "{sentence}");
            assert!(parse(meant).is_ok(), "{meant}");
        }
    }

    #[test]
    fn what_may_be_meant_otherwise_is_not_left_out() {
        for sentence in [
            // Either of the two.
            "put red on lego no small",
            "put the red on the lego no the small",
            // Whether it is small is left open.
            "put red small no green on lego",
            "put topmost red no green on lego",
            // What stands before it is not said again.
            "put red no the green on lego",
            "put red never on lego",
            "put red on green no then put lego on green",
            // One of the red ones is left out, or all.
            "put red never lego on green",
            "put red never red on green",
            // Of which one is it said that it is on the small one?
            "put red never green on small on lego",
            "no red on green",
            "put red on green no",
            "put red on green then no lego",
        ] {
            let refusal = parse(sentence).unwrap_err();
            assert_eq!(refusal.kind(), "unknown_word", "{sentence}");
        }
        // All of its words are known.
        assert_eq!(
            parse("put red near lego on green"),
            fixture::parse(&fixture::with_table(), "put red near lego on green")
        );
    }
}
