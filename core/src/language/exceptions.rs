//! What is left out of a description: "all blocks except the red one", "the small block that is not red".
//!
//! The words are left out, so that the network reads "all blocks", and what they say is kept with the description that
//! they belong to. Nothing is learned here: the model lists the words ([`crate::model::Exceptions`]).

use core::ops::Range;

use super::phrases::PhraseMatcher;
use super::plurals::Number;
use super::tokens::{Kept, KeptKind, Tokens};
use super::{Token, TokenKind};
use crate::dsl::{Filters, Property, Quantifier};
use crate::refusal::Refusal;

/// The words of an exception among the tokens.
pub(super) struct Excepted {
    words: Range<usize>,
    /// Index of the description from which it is left out; of the noun, if that says nothing else.
    from: usize,
    filters: Filters,
}

impl PhraseMatcher<'_, '_> {
    /// What the words at a token leave out.
    pub(super) fn exception(&self, tokens: &[Token], at: usize) -> Option<Excepted> {
        let exceptions = self.model.exceptions;
        let rest = tokens.get(at..)?;
        let longest = |texts| {
            let (length, _) = self.longest::<&str>(rest, texts)?;
            let words = at..at.checked_add(length)?;
            // Others have a meaning of their own.
            let is_unknown = |token: &Token| token.kind == TokenKind::Unknown;
            tokens
                .get(words.clone())?
                .iter()
                .any(is_unknown)
                .then_some(words)
        };
        match longest(exceptions.phrases) {
            Some(words) => self.left_out(tokens, words),
            None => self.negated(tokens, longest(exceptions.negations)?),
        }
    }

    /// Objects that are left out of all that are described before: directly before, or anywhere in the clause that
    /// ends behind them.
    fn left_out(&self, tokens: &[Token], said: Range<usize>) -> Option<Excepted> {
        let behind = said.end.checked_add(1)?;
        let has_article = self.is_article(tokens, behind);
        let group = if has_article { behind } else { said.end };
        let mut filters = self.excepted(tokens.get(group)?)?;
        let mut end = group.checked_add(1)?;
        let number = tokens.get(end).and_then(|token| self.number(token));
        end = end.checked_add(usize::from(number.is_some()))?;
        if number == Some(Number::Several) || (number.is_none() && !has_article) {
            // It has room.
            let _ = filters.add(Property::Quantifier(Quantifier::All));
        }
        let mut words = said.start..end;
        let before = |index: usize| tokens.get(index.checked_sub(1)?);
        let is_comma = |token: &Token| self.is_comma(token);
        if before(words.start).is_some_and(is_comma) {
            words.start = words.start.checked_sub(1)?;
            words.end = self.behind_comma(tokens, words.end);
        }
        let clause = self.clause(tokens, &said)?;
        let mut several = (clause.start..words.start).filter(|index| {
            let filters = tokens.get(*index).and_then(Token::filters);
            filters.is_some_and(|filters| filters.quantifier().is_some())
        });
        let from = several.next().filter(|_| several.next().is_none())?;
        let noun = from.checked_add(1)?;
        let is_noun = tokens
            .get(noun)
            .is_some_and(|token| self.number(token).is_some());
        let is_next = noun.checked_add(usize::from(is_noun))? == words.start;
        let ends = tokens
            .get(words.end)
            .is_none_or(|token| self.separates(token));
        (is_next || ends).then_some(Excepted {
            words,
            from,
            filters,
        })
    }

    /// Values that the object described directly before does not have.
    fn negated(&self, tokens: &[Token], said: Range<usize>) -> Option<Excepted> {
        let mut filters = self.excepted(tokens.get(said.end)?)?;
        let _ = filters.add(Property::Quantifier(Quantifier::All));
        let end = said.end.checked_add(1)?;
        let goes_on = |token: &Token| token.is_group() || self.number(token).is_some();
        if tokens.get(end).is_some_and(goes_on) {
            return None;
        }
        let last = said.start.checked_sub(1)?;
        let is_group = |index: usize| tokens.get(index).is_some_and(Token::is_group);
        let group = last.checked_sub(1).filter(|index| is_group(*index));
        let from = match (is_group(last), self.number(tokens.get(last)?), group) {
            (true, ..) => last,
            (false, Some(_), Some(group)) => group,
            (false, Some(Number::One), None) => last,
            _ => return None,
        };
        Some(Excepted {
            words: said.start..end,
            from,
            filters,
        })
    }

    /// What a group says of objects that are left out.
    fn excepted(&self, token: &Token) -> Option<Filters> {
        let filters = token.filters()?.distinct();
        let is_plain = matches!(
            filters.choice(),
            None | Some(Property::Quantifier(Quantifier::All))
        );
        (is_plain && !filters.concepts().is_empty()).then_some(filters)
    }

    /// Leaves the words of an exception out of the tokens; what is kept of it, and the index of the token behind
    /// them.
    pub(super) fn leave_exception_out(
        &self,
        tokens: &mut Tokens,
        found: &Excepted,
    ) -> Result<(Kept, usize), Refusal> {
        let from = found.from;
        let described = *tokens.get(from).ok_or(Refusal::InvalidModel)?;
        let mut behind = self.replace(tokens, &found.words, "", described.span)?;
        if !described.is_group() {
            // "The block that is not red" has no description: an empty one goes before the noun.
            Self::resize(tokens, &(from..from), 1, described.span)?;
            let group = tokens.get_mut(from).ok_or(Refusal::InvalidModel)?;
            group.kind = TokenKind::Group(Filters::new());
            behind = behind.saturating_add(1);
        }
        let exception = Kept {
            at: described.span.start,
            filters: found.filters,
            kind: KeptKind::Exception,
        };
        Ok((exception, behind))
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use crate::fixture;

    /// How a sentence is understood, with shorter names.
    fn read(sentence: &str) -> String {
        fixture::read(&fixture::with_exceptions(), sentence)
            .replace("Action(MoveOn, ", "(")
            .replace(", Unique(Filter(lego, Scene())))", ")")
    }

    #[test]
    fn objects_are_left_out_of_all_that_fit() {
        let one = "(All(Except(Unique(Filter(red, Scene())), Filter(small, Scene()))))";
        for sentence in [
            "put all small near except the red near on lego",
            "put all small except the red near on lego",
            "put all small , except the red , on lego",
            "put all small except for the red near on lego",
            "put all small on lego except the red near",
            "put all small on lego , except the red",
        ] {
            assert_eq!(read(sentence), one, "{sentence}");
        }
        let several = one.replace("Unique", "All");
        for sentence in [
            "put all small except red on lego",
            "put all small near except the red nears on lego",
            "put all small except all red on lego",
            "put all small near that isn't red on lego",
        ] {
            assert_eq!(read(sentence), several, "{sentence}");
        }
        assert_eq!(
            read("put all except the small red red near on lego"),
            "(All(Except(Unique(Filter(small, Filter(red, Scene()))), Scene())))"
        );
        assert_eq!(
            read("put all small except the red on lego then put red on lego"),
            [one, "(Unique(Filter(red, Scene())))"].join("\n")
        );
    }

    #[test]
    fn an_object_is_said_by_what_it_is_not() {
        for (sentence, expected) in [
            (
                "put the small near that isn't red on lego",
                "(Unique(Except(All(Filter(red, Scene())), Filter(small, Scene()))))",
            ),
            (
                "put the near that isn't red on lego",
                "(Unique(Except(All(Filter(red, Scene())), Scene())))",
            ),
            (
                "put green right the small that isn't red",
                "Action(MoveRight, Unique(Filter(green, Scene())), \
                 Unique(Except(All(Filter(red, Scene())), Filter(small, Scene()))))",
            ),
        ] {
            assert_eq!(read(sentence), expected, "{sentence}");
        }
    }

    #[test]
    fn what_is_left_out_of_nothing_is_refused() {
        for sentence in [
            // Of a single object, or of what is not said to be several.
            "put the small near except the red near on lego",
            "put small on lego except red",
            // Nothing, or what compares.
            "put all small except on lego",
            "put all small except the rightmost on lego",
            // What follows is another place.
            "put all small on lego except the red near on green",
            // The anchor of a relation.
            "put small above the near that isn't red on lego",
            // Nothing before, or a noun behind.
            "that isn't red put small on lego",
            "put the small near that isn't red near on lego",
        ] {
            let kind = read(sentence);
            let is_refused = matches!(
                &*kind,
                "unclear_words" | "unknown_word" | "unsure" | "incomplete_step"
            );
            assert!(is_refused, "{sentence}: {kind}");
        }
    }

    #[test]
    fn more_exceptions_than_there_can_be_steps_are_refused() {
        let sentence = ["put all small except red on lego"; 9].join(" then ");
        assert_eq!(read(&sentence), "unknown_word");
    }
}
