//! What is counted from one side: "the second red block from the left", "the second leftmost one", "the red
//! block on the far left".
//!
//! The words that count, and those that say from where, are left out, and what they mean becomes a part of the
//! description, "the [second leftmost red] block", which the network reads and judges as it does "the leftmost
//! red block". Nothing is learned here: the model lists what is said ([`crate::model::Ordinals`]).

use core::ops::Range;

use super::phrases::PhraseMatcher;
use super::tokens::{Tokens, push};
use super::words::find;
use super::{Token, TokenKind};
use crate::dsl::{Extreme, Property};
use crate::model::CountedFrom;
use crate::refusal::Refusal;

/// Which one of several is meant, as it stands among the tokens.
pub(super) struct Counted {
    /// The word that counts, if there is one, with "that is" before it.
    count: Range<usize>,
    /// The words that say from where, if there are any; with "that is" if nothing counts.
    from: Range<usize>,
    /// Index of the group that describes the object, or of the token before which one is put.
    group: usize,
    meant: Property,
}

impl Counted {
    /// Index of the token behind all of them.
    pub(super) fn behind(&self) -> usize {
        self.count.end.max(self.from.end)
    }

    /// Whether the words mean nothing else: one of them is unknown.
    pub(super) fn is_sure(&self, tokens: &[Token]) -> bool {
        let words = [&self.count, &self.from].into_iter();
        let mut words = words.flat_map(|words| tokens.get(words.clone()).unwrap_or_default());
        words.any(|token| token.kind == TokenKind::Unknown)
    }
}

impl<'a> PhraseMatcher<'_, 'a> {
    /// What is counted by the word at a token, or named as the first by the words that begin there.
    pub(super) fn counted(&self, tokens: &[Token], at: usize) -> Option<Counted> {
        match self.count(tokens, at) {
            Some(rank) => self
                .counted_extreme(tokens, at, rank)
                .or_else(|| self.counted_from(tokens, at, rank)),
            None => self.first_from(tokens, at),
        }
    }

    /// "The second leftmost red one".
    fn counted_extreme(&self, tokens: &[Token], at: usize, rank: u8) -> Option<Counted> {
        let group = at.checked_add(1)?;
        let token = tokens.get(group)?;
        let Property::Extreme(extreme) = token.filters()?.choice()? else {
            return None;
        };
        let first = self.text(token).split(char::is_whitespace).next()?;
        let (_, named) = find(self.model.lexicon, first, |entry| entry.text)?;
        if named.property != Property::Extreme(extreme) || !self.is_article(tokens, at) {
            return None;
        }
        Some(Counted {
            count: at..group,
            from: group..group,
            group,
            meant: self.ranked(extreme, rank)?,
        })
    }

    /// "The second red block from the left", "the red block second from the left", "the second from the left".
    fn counted_from(&self, tokens: &[Token], at: usize, rank: u8) -> Option<Counted> {
        let behind = at.checked_add(1)?;
        let own = tokens.get(behind).filter(|token| self.is_open(token));
        let noun = behind.checked_add(usize::from(own.is_some()))?;
        let nouns = tokens.get(noun..)?.iter();
        let nouns = nouns.take_while(|token| self.is_one_of(self.model.ordinals.nouns, token));
        let start = noun.checked_add(nouns.count())?;
        let (from, end) = self.from(tokens, start)?;
        let (group, begin) = if own.is_some() || start > behind {
            (behind, at)
        } else if let Some(described) = self.described_before(tokens, at) {
            described
        } else {
            (self.is_article(tokens, at).then_some(at)?, at)
        };
        Some(Counted {
            count: begin..behind,
            from: start..end,
            group,
            meant: self.ranked(from.extreme, rank)?,
        })
    }

    /// "The red block on the far left".
    fn first_from(&self, tokens: &[Token], at: usize) -> Option<Counted> {
        let first = tokens.get(at)?;
        if !self.is_one_of(self.model.ordinals.first_words, first) {
            return None;
        }
        let (from, end) = self.from(tokens, at).filter(|(from, _)| from.is_first)?;
        let (group, begin) = self.described_before(tokens, at)?;
        Some(Counted {
            count: at..at,
            from: begin..end,
            group,
            meant: Property::Extreme(from.extreme),
        })
    }

    /// The number that a token counts.
    fn count(&self, tokens: &[Token], at: usize) -> Option<u8> {
        let token = tokens.get(at).filter(|token| !token.is_group())?;
        let counts = self.model.ordinals.counts;
        let at = counts.partition_point(|count| self.is_behind(token, count.text));
        let count = counts.get(at).filter(|count| self.is(token, count.text))?;
        Some(count.rank)
    }

    /// The longest text with which the tokens from this one on begin, and the index behind it.
    fn from(&self, tokens: &[Token], at: usize) -> Option<(&'a CountedFrom<'a>, usize)> {
        let ordinals = self.model.ordinals;
        let rest = tokens.get(at..)?;
        rest.first().filter(|token| !token.is_group())?;
        let (length, from) = self.longest(rest, ordinals.from)?;
        let end = at.checked_add(length)?;
        let behind = tokens.get(end);
        let goes_on = behind.is_some_and(|token| self.is_one_of(ordinals.unless, token));
        (!goes_on).then_some((from, end))
    }

    /// What the words that begin at a token say more of: the index of the group before the nouns that stand before
    /// them, or of the first of these, and that of the first word of "that is" in between, or of the token.
    fn described_before(&self, tokens: &[Token], at: usize) -> Option<(usize, usize)> {
        let before = tokens.get(..at)?;
        let phrases = self.model.apart.phrases.iter();
        let length = phrases
            .filter_map(|text| self.ends_with(before, text))
            .max();
        let begin = at.checked_sub(length.unwrap_or(0))?;
        let nouns = tokens.get(..begin)?.iter().rev();
        let nouns = nouns.take_while(|token| self.is_one_of(self.model.ordinals.nouns, token));
        let nouns = nouns.count();
        let noun = begin.checked_sub(nouns)?;
        let group = noun.checked_sub(1);
        let group = group.filter(|group| tokens.get(*group).is_some_and(|it| self.is_open(it)));
        let described = group.or((nouns > 0).then_some(noun))?;
        Some((described, begin))
    }

    /// Whether a token is a group that leaves open which one is meant.
    fn is_open(&self, token: &Token) -> bool {
        token
            .filters()
            .is_some_and(|filters| filters.choice().is_none())
    }

    /// Whether an article stands before a token.
    pub(super) fn is_article(&self, tokens: &[Token], at: usize) -> bool {
        let before = at.checked_sub(1).and_then(|before| tokens.get(before));
        before.is_some_and(|token| self.is_one_of(self.model.ordinals.articles, token))
    }

    /// What is meant; `None` if the model has no name for it.
    fn ranked(&self, extreme: Extreme, rank: u8) -> Option<Property> {
        if rank == 1 {
            return Some(Property::Extreme(extreme));
        }
        let mut ranked = self.model.ordinals.ranked.iter();
        let index = ranked.position(|ranked| (ranked.extreme, ranked.rank) == (extreme, rank))?;
        u8::try_from(index).ok().map(Property::Ranked)
    }

    /// The tokens with these words left out and what they mean in a group, and the index of this group.
    pub(super) fn with_counted(
        &self,
        tokens: &[Token],
        counted: &Counted,
    ) -> Result<(Tokens, usize), Refusal> {
        let mut read = Tokens::new();
        let mut group = 0;
        for (index, token) in tokens.iter().enumerate() {
            let (mut kind, is_group) = (token.kind, index == counted.group);
            if is_group {
                group = read.len();
                let mut filters = token.filters().copied().unwrap_or_default();
                // Which one is no concept: it has room.
                let _ = filters.add(counted.meant);
                match kind {
                    TokenKind::Group(_) => kind = TokenKind::Group(filters),
                    _ => push(&mut read, TokenKind::Group(filters), token.span)?,
                }
            }
            if !counted.count.contains(&index) && !counted.from.contains(&index) {
                push(&mut read, kind, token.span)?;
            }
        }
        Ok((read, group))
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use crate::fixture;

    /// How a sentence is understood, with shorter names.
    fn read(sentence: &str) -> String {
        fixture::read(&fixture::with_ordinals(), sentence)
            .replace("Unique(", "(")
            .replace("MoveRight, ", "")
            .replace("Filter(", "(")
            .replace(", Scene()", "")
    }

    #[test]
    fn what_is_counted_is_a_part_of_the_description() {
        let second_red = "Action(MoveOn, (Extreme(2, (red))), ((green)))";
        for sentence in [
            "put the second red from right on green",
            "put the second red near from right on green",
            "put the Second red from the far right on green",
            "put the red second from right on green",
            "put the red near second from right on green",
            "put the second rightmost red on green",
            "put the second  RIGHTMOST red on green",
        ] {
            assert_eq!(read(sentence), second_red, "{sentence}");
        }
        for (sentence, expected) in [
            // All words are known, and make no other sense.
            (
                "put the perhaps near right on green",
                "Action(MoveOn, (Extreme(2, Scene())), ((green)))",
            ),
            (
                "put the third near from right on green",
                "Action(MoveOn, (Extreme(3, Scene())), ((green)))",
            ),
            (
                "put the near third from right on green",
                "Action(MoveOn, (Extreme(3, Scene())), ((green)))",
            ),
            (
                "put the third from right on green",
                "Action(MoveOn, (Extreme(3, Scene())), ((green)))",
            ),
            (
                "put the first red from right on green",
                "Action(MoveOn, (Extreme((red))), ((green)))",
            ),
            (
                "put red on the green nearby right",
                "Action(MoveOn, ((red)), (Extreme((green))))",
            ),
            (
                "put the red near whose is third from right on the green whose is nearby right",
                "Action(MoveOn, (Extreme(3, (red))), (Extreme((green))))",
            ),
            (
                "put red on the , nearby right",
                "Action(MoveOn, ((red)), (Extreme(Scene())))",
            ),
            (
                "put the second largest on the second topmost red",
                "Action(MoveOn, (Extreme(Largest, 2, Scene())), (Extreme(MoveOn, 2, (red))))",
            ),
            (
                "put the second from above on the red third from right then put lego on small",
                "Action(MoveOn, (Extreme(MoveOn, 2, Scene())), (Extreme(3, (red))))\n\
                 Action(MoveOn, ((lego)), ((small)))",
            ),
        ] {
            let expected = expected.replace("Extreme(Scene())", "Extreme(MoveRight, Scene())");
            let expected = expected.replace("MoveRight, ", "").replace(", Scene()", "");
            assert_eq!(read(sentence), expected, "{sentence}");
        }
    }

    #[test]
    fn known_words_that_also_make_another_sense_are_refused() {
        assert_eq!(read("put the perhaps red right on green"), "unclear_words");
    }

    #[test]
    fn what_counts_nothing_stays_unknown() {
        for sentence in [
            "put the second red on green",
            "put red on green from right",
            "put the second red from right of green on lego",
            "put red nearby right of green",
            // The model has no name for it.
            "put the third topmost red on green",
            "put the third red from above on green",
            // No article stands before a count without a noun.
            "put second from right on green",
            "put red on second rightmost green",
            // It says already which one.
            "put the second rightmost red from right on green",
            "put the second topmost red from right on green",
            "put the second all red from right on green",
            // The count stands before another word.
            "put the second then red from right on green",
            "second put red from right on green",
        ] {
            assert_eq!(read(sentence), "unknown_word", "{sentence}");
        }
    }
}
