//! Towers and rows: "build a tower of the red block, the green one and the blue one".
//!
//! The words of such an arrangement are replaced by those of its steps, "put the green one on the red
//! block , then put the blue one on it", which the network reads and judges as if they had been said; those of "stack all
//! red blocks" by "put all red blocks on [each other]".
//! Nothing is learned here: the model lists what stands before and behind the objects, and what it means
//! ([`crate::model::Arrangements`]).

use heapless::Vec;

use super::phrases::{PhraseMatcher, parts};
use super::tokens::{push, span_of};
use super::words::{find, letters};
use super::{Span, Token, TokenKind, Tokens};
use crate::capacity::MAX_STEPS;
use crate::dsl::{Filters, Property, Quantifier};
use crate::model::{Arrangement, Closing, Model};
use crate::refusal::Refusal;

/// What is said of the objects of a list, one each: one step fewer than objects; or of several at once.
type Items<'t> = Vec<&'t [Token], { MAX_STEPS + 1 }, u8>;

/// An arrangement in a sentence, from one of its tokens on.
pub(super) struct Found<'a, 't> {
    arrangement: &'a Arrangement<'a>,
    /// The place of what stands before the list.
    opening: Span,
    items: Items<'t>,
    /// How many objects are listed.
    count: usize,
    /// How many tokens it has.
    length: usize,
    /// How many of them do not belong to the list.
    around: usize,
}

impl<'a> PhraseMatcher<'_, 'a> {
    /// The arrangement whose first token is the first of these; of several the one of which more is
    /// said around the list.
    ///
    /// Cost: a binary search among the openings, and for each opening that is there, comparisons of
    /// each closing with each further token.
    #[inline(never)]
    pub(super) fn arrangement<'t>(&self, tokens: &'t [Token]) -> Option<Found<'a, 't>> {
        let said = self.model.arrangements;
        let first = tokens.first().filter(|token| !token.is_group())?;
        let openings = said.openings;
        let from = openings.partition_point(|opening| self.is_behind(first, opening.text));
        let mut best: Option<Found<'a, 't>> = None;
        for opening in openings.get(from..)? {
            if !self.is(first, parts(opening.text).next().unwrap_or_default()) {
                break;
            }
            let Some(opened) = self.begins_with(tokens, opening.text) else {
                continue;
            };
            let Some(rest) = tokens.get(opened..) else {
                continue;
            };
            let Some(end) = self.list_end(rest).or_else(|| self.several_end(rest)) else {
                continue;
            };
            for closing in said.closings {
                if closing.pattern != opening.pattern {
                    continue;
                }
                let Some(found) = self.closed(tokens, opened, end, closing) else {
                    continue;
                };
                if best.as_ref().is_none_or(|best| best.around < found.around) {
                    best = Some(found);
                }
            }
        }
        best
    }

    /// How many of these tokens may belong to a list that begins with the first, or begin its closing; `None`
    /// if they do not begin with one: a first object, what separates it from the next, and that one.
    fn list_end(&self, tokens: &[Token]) -> Option<usize> {
        let group = tokens.iter().position(Token::is_group)?;
        let behind = tokens.get(group..)?.get(1..)?;
        let item = behind
            .iter()
            .position(|token| token.is_group() || self.is_between(token))?;
        let rest = behind.get(item..)?;
        if rest.first()?.is_group() {
            return None;
        }
        let ends = |token: &Token| self.is_one_of(self.model.arrangements.ends, token);
        let end = tokens.iter().position(ends).unwrap_or(tokens.len());
        let listed = tokens.get(..end)?;
        let mut groups = listed.iter().filter(|token| token.is_group());
        groups.nth(1).map(|_| end)
    }

    /// The same of tokens of which the first group describes several objects: "all red blocks".
    fn several_end(&self, tokens: &[Token]) -> Option<usize> {
        let group = tokens.iter().position(Token::is_group)?;
        let ends = |token: &Token| self.is_one_of(self.model.arrangements.ends, token);
        let end = tokens.iter().position(ends).unwrap_or(tokens.len());
        (group < end && is_several(tokens.get(group)?)).then_some(end)
    }

    /// Whether the sentence separates objects, or describes several at once.
    pub(super) fn has_list(&self, tokens: &[Token]) -> bool {
        !self.model.arrangements.openings.is_empty()
            && tokens
                .iter()
                .any(|token| self.is_between(token) || is_several(token))
    }

    /// The arrangement with this closing.
    ///
    /// * `opened`: how many tokens stand before the list
    /// * `end`: how many tokens behind these may belong to it, or begin the closing
    fn closed<'t>(
        &self,
        tokens: &'t [Token],
        opened: usize,
        end: usize,
        closing: &Closing<'_>,
    ) -> Option<Found<'a, 't>> {
        let said = self.model.arrangements;
        let rest = tokens.get(opened..)?;
        let mut listed = rest.get(..end)?;
        let mut closed = 0;
        if closing.text.is_empty() {
            listed = self.before_others(listed);
        } else {
            let closes = |at: &usize| self.begins_with(rest.get(*at..)?, closing.text);
            let (at, length) = (0..end).find_map(|at| Some((at, closes(&at)?)))?;
            (listed, closed) = (listed.get(..at)?, length);
        }
        let arrangement = said.arrangements.get(usize::from(closing.arrangement))?;
        let length = opened + listed.len() + closed;
        // A further description belongs to another step, or says what no arrangement means.
        let behind = tokens.get(length..)?;
        let mut behind = behind
            .iter()
            .take_while(|token| !self.is_one_of(said.ends, token));
        if behind.any(Token::is_group) {
            return None;
        }
        let (items, count) = self.items(listed)?;
        let (last, others) = items.split_last()?;
        let is_unknown = |token: &Token| token.kind == TokenKind::Unknown;
        // Only the last one may be in the plural.
        let is_list = !others.is_empty() || last.iter().any(is_several);
        if !is_list || others.iter().any(|item| item.iter().any(is_unknown)) {
            return None;
        }
        let words = tokens.get(..opened)?;
        Some(Found {
            arrangement,
            opening: span_of(words)?,
            items,
            count,
            length,
            around: opened + closed,
        })
    }

    /// What is said of each object of a list, and how many these are: from one separator to another, with
    /// those before the object itself, as in "the, um, red block".
    fn items<'t>(&self, mut listed: &'t [Token]) -> Option<(Items<'t>, usize)> {
        let (mut items, mut count) = (Items::new(), 0_usize);
        loop {
            while let Some((first, rest)) = listed.split_first()
                && self.is_between(first)
            {
                listed = rest;
            }
            if listed.is_empty() {
                return Some((items, count));
            }
            let group = listed.iter().position(Token::is_group)?;
            let behind = listed.get(group..)?;
            let length = behind.iter().position(|token| self.is_between(token));
            let length = group.saturating_add(length.unwrap_or(behind.len()));
            let (item, rest) = listed.split_at_checked(length)?;
            if item.iter().filter(|token| token.is_group()).count() != 1 {
                return None;
            }
            // More are too many steps.
            let _ = items.push(item);
            (listed, count) = (rest, count.saturating_add(1));
        }
    }

    /// Appends the words of an arrangement's steps to those before it.
    pub(super) fn write(&self, found: &Found<'_, '_>, tokens: &mut Tokens) -> Result<(), Refusal> {
        if found.count > found.items.len() {
            return Err(Refusal::TooManySteps {
                limit: MAX_STEPS as u8,
            });
        }
        if let [several] = found.items.as_slice() {
            // Each of them in relation to another one.
            self.write_words(found.arrangement.order, found.opening, tokens)?;
            self.write_item(several, tokens)?;
            self.write_words(found.arrangement.relation, found.opening, tokens)?;
            let mut each_other = Filters::new();
            // It has room.
            let _ = each_other.add(Property::Itself);
            return push(tokens, TokenKind::Group(each_other), found.opening);
        }
        let mut before: Option<&[Token]> = None;
        for number in 0..found.items.len() {
            let last = found.items.len().saturating_sub(1);
            let listed = match found.arrangement.is_reversed {
                true => last.saturating_sub(number),
                false => number,
            };
            let Some(item) = found.items.get(listed) else {
                continue;
            };
            let Some(first) = before.replace(item) else {
                continue;
            };
            if number > 1 {
                self.write_words(self.model.arrangements.next, found.opening, tokens)?;
            }
            self.write_words(found.arrangement.order, found.opening, tokens)?;
            self.write_item(item, tokens)?;
            self.write_words(found.arrangement.relation, found.opening, tokens)?;
            if number > 1 {
                // What the step before moved: it may be described by where it was.
                let span = first
                    .iter()
                    .find(|token| token.is_group())
                    .map_or(found.opening, |group| group.span);
                push(tokens, TokenKind::Pronoun, span)?;
            } else {
                self.write_item(first, tokens)?;
            }
        }
        Ok(())
    }

    /// Plurals are read as singulars: "the red, green and blue blocks".
    fn write_item(&self, item: &[Token], tokens: &mut Tokens) -> Result<(), Refusal> {
        for token in item {
            let plurals = self.model.several.plurals;
            let text = token.span.of(self.sentence).unwrap_or_default();
            let kind = match (token.kind, find(plurals, text, |plural| plural.text)) {
                (TokenKind::Unknown, Some((_, plural))) => TokenKind::Word(plural.word),
                (kind, _) => kind,
            };
            push(tokens, kind, token.span)?;
        }
        Ok(())
    }

    /// A list without what is said behind its last object: ", please" and ", and".
    fn before_others<'t>(&self, mut listed: &'t [Token]) -> &'t [Token] {
        loop {
            let last = listed.iter().rposition(|token| self.is_between(token));
            let (before, item) = match last {
                Some(at) => listed.split_at_checked(at).unwrap_or_default(),
                None => return listed,
            };
            if item.iter().any(Token::is_group) {
                return listed;
            }
            listed = before;
        }
    }

    fn is_between(&self, token: &Token) -> bool {
        self.is_one_of(self.model.arrangements.between, token)
    }
}

/// Whether a token describes several objects.
pub(super) fn is_several(token: &Token) -> bool {
    let quantifier = token.filters().and_then(Filters::quantifier);
    matches!(quantifier, Some(Quantifier::All | Quantifier::Both))
}

impl Found<'_, '_> {
    /// How many tokens it has.
    pub(super) const fn length(&self) -> usize {
        self.length
    }
}

/// How a word is said that only towers and rows have: what stands before and behind a list.
pub(crate) fn said_around<'a>(model: &Model<'a>, word: &str) -> Option<(&'a str, &'a str)> {
    let said = &model.arrangements;
    let has = |text: &str| parts(text).any(|part| letters(word).eq(part.chars()));
    let opening = said.openings.iter().find(|opening| has(opening.text));
    let closing = said.closings.iter().find(|closing| match opening {
        Some(opening) => closing.pattern == opening.pattern,
        None => has(closing.text),
    })?;
    let opening = opening.or_else(|| {
        let mut openings = said.openings.iter();
        openings.find(|opening| opening.pattern == closing.pattern)
    })?;
    Some((opening.text, closing.text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::model::{Arrangements, Opening, Plural, Several};

    const LISTS: Arrangements<'static> = Arrangements::new()
        .with_between(&[",", "and"])
        .with_ends(&["then"])
        .with_next(", then")
        .with_arrangements(&[
            Arrangement::new().with_order("put").with_relation("on"),
            Arrangement::new().with_order("put").with_relation("right"),
            Arrangement::new()
                .with_order("put the")
                .with_relation("on")
                .with_is_reversed(true),
        ])
        .with_openings(&[
            Opening::new().with_text("line").with_pattern(1),
            Opening::new().with_text("put").with_pattern(1),
            Opening::new().with_text("the tower of").with_pattern(0),
        ])
        .with_closings(&[
            Closing::new().with_pattern(0).with_arrangement(0),
            Closing::new()
                .with_text("in line")
                .with_pattern(1)
                .with_arrangement(1),
            Closing::new()
                .with_text("from the top")
                .with_pattern(0)
                .with_arrangement(2),
        ]);

    fn parse(sentence: &str) -> Result<std::string::String, Refusal> {
        let model = fixture::model();
        let the = model.words.iter().position(|word| word.text == "the");
        let plural = Plural {
            text: "blocks",
            word: u16::try_from(the.unwrap()).unwrap(),
        };
        let several = Several::new().with_plurals(std::slice::from_ref(&plural));
        let model = model.with_arrangements(LISTS).with_several(several);
        assert_eq!(model.check(), Ok(()));
        fixture::parse(&model, sentence)
    }

    #[test]
    fn an_arrangement_is_read_as_its_steps() {
        for (sentence, meant) in [
            ("the tower of red and green", "put green on red"),
            (
                "the tower of the red , small , and lego blocks",
                "put small on red then put lego on small",
            ),
            (
                "The Tower of red, green, small from the top",
                "put green on small then put red on green",
            ),
            (
                "put red and the small and green in line",
                "put small right red then put green right small",
            ),
            (
                "put red on green then the tower of small and lego, then put red right small",
                "put red on green then put lego on small then put red right small",
            ),
            (
                "the tower of red , green then line small and lego in line",
                "put green on red then put lego right small",
            ),
        ] {
            assert_eq!(parse(sentence), parse(meant), "{sentence}");
            assert!(parse(meant).is_ok(), "{meant}");
        }
    }

    #[test]
    fn a_command_that_may_be_one_is_read_as_it_stands_first() {
        let meant = parse("put red on green");
        assert_eq!(parse("put red , on green"), meant);
        assert!(meant.is_ok());
    }

    #[test]
    fn words_of_arrangements_are_unknown_elsewhere() {
        for (sentence, word) in [
            ("put red on green then tower", "tower"),
            ("the tower of red", "tower"),
            ("the tower of red or green", "tower"),
            ("the tower of red and green on lego", "tower"),
            ("the tower of red and huge", "tower"),
            ("the tower of red blocks and green", "tower"),
            ("the tower of red and green from the bottom", "from"),
            ("put the tower of red and green in a row", "in"),
            ("line red and green", "line"),
            ("put red on green blocks", "blocks"),
            // The first one, whatever is wrong with those behind it.
            ("put tower red green", "tower"),
        ] {
            let refusal = parse(sentence).unwrap_err();
            let Refusal::UnknownWord { span } = refusal else {
                panic!("{sentence}: {refusal:?}");
            };
            assert_eq!(span.of(sentence), Some(word), "{sentence}");
        }
    }

    #[test]
    fn arrangements_have_as_many_objects_as_steps_and_one() {
        let most = std::format!(
            "the tower of red{}",
            " and red, and green".repeat(MAX_STEPS / 2)
        );
        assert!(parse(&most).is_ok());
        let more = most + " and red";
        assert_eq!(parse(&more).unwrap_err().kind(), "too_many_steps");
    }
}
