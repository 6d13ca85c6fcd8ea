//! Two steps that are said in another order than that in which they are carried out: "before you put the red
//! block on the blue one, put the green block on the white one".
//!
//! They are put in order, "put the green block on the white one, then put the red block on the blue one", which
//! the network reads and judges as if they had been said so. Nothing is learned here: the model lists the words
//! ([`crate::model::Sequence`]).

use core::ops::Range;

use super::phrases::{PhraseMatcher, parts};
use super::tokens::{Tokens, push, span_of};
use super::words::letters;
use super::{Span, Token};
use crate::model::{Model, SequenceText};
use crate::refusal::Refusal;

/// Words that say in which order two steps are carried out.
pub(super) struct Order<'a> {
    /// Their tokens.
    said: Range<usize>,
    text: &'a SequenceText<'a>,
    /// Whether the step behind them is carried out second.
    is_later: bool,
}

impl Order<'_> {
    /// Their place in the sentence.
    pub(super) fn span(&self, tokens: &[Token]) -> Span {
        span_of(tokens.get(self.said.clone()).unwrap_or_default()).unwrap_or_default()
    }
}

/// Two steps and the order in which they are carried out.
pub(super) struct Sequenced<'a> {
    /// What stands before both.
    lead: Range<usize>,
    /// The step that is carried out first,
    first: Range<usize>,
    /// and the other one.
    second: Range<usize>,
    /// What is read before the first step in place of the words that say so,
    before_first: &'a str,
    /// and before the other one.
    before_second: &'a str,
}

/// Where the first of two steps ends, if a comma stands before the verb of the other one and not directly:
/// "…, please put …", or "… next to the blue one, on its left put …".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepEnd {
    /// At the comma.
    Comma,
    /// Before the verb.
    Verb,
}

impl<'a> PhraseMatcher<'_, 'a> {
    /// The words at a token, if they say in which order steps are carried out. Where nothing is read in their place,
    /// a verb stands behind them, unlike in "after you have done that".
    pub(super) fn order(&self, tokens: &[Token], at: usize) -> Option<Order<'a>> {
        let sequence = self.model.sequence;
        let rest = tokens.get(at..)?;
        if !self.is_one_of(sequence.first_words, rest.first()?) {
            return None;
        }
        let longest = |texts: &'a [SequenceText<'a>]| self.longest(rest, texts);
        let (later, earlier) = (longest(sequence.later), longest(sequence.earlier));
        let length = |found: Option<(usize, _)>| found.map_or(0, |(length, _)| length);
        let is_later = length(later) > length(earlier);
        let (length, text) = if is_later { later? } else { earlier? };
        let said = at..at.checked_add(length)?;
        let is_verb = || tokens.get(said.end).is_some_and(|token| self.ends(token));
        let is_order = text.is_afterthought || !text.read_as.is_empty() || is_verb();
        is_order.then_some(Order {
            said,
            text,
            is_later,
        })
    }

    /// Two steps in this order; `None` if they are not, or may not be, the only ones in the sentence.
    pub(super) fn sequenced(
        &self,
        tokens: &[Token],
        order: &Order<'a>,
        end: StepEnd,
    ) -> Option<Sequenced<'a>> {
        let Order {
            said,
            text,
            is_later,
        } = order;
        let from = self.behind_comma(tokens, said.end);
        let before = tokens.get(..said.start)?;
        let (lead, other, own) = if before.iter().any(Token::is_group) {
            let other = 0..self.before_mark(tokens, said.start)?;
            let lead = self.lead(tokens.get(other.clone())?)?;
            (0..lead, lead..other.end, from..tokens.len())
        } else if text.is_afterthought {
            return None;
        } else {
            let (own, other) = self.both(tokens, from, end)?;
            // "After you put …, then put …", but not "before you put …, then put …".
            let (word, next) = (tokens.get(other.start)?, self.model.sequence.next);
            let is_next = parts(next).any(|part| self.is(word, part));
            if is_next && *is_later {
                return None;
            }
            let start = other.start.checked_add(usize::from(is_next))?;
            (0..said.start, start..other.end, own)
        };
        let is_one = |step: &Range<usize>| self.is_one_step(tokens.get(step.clone())?);
        if !(is_one(&other)? && is_one(&own)?) {
            return None;
        }
        let (first, second) = if *is_later {
            (other, own)
        } else {
            (own, other)
        };
        let (before_first, before_second) = match is_later {
            true => ("", text.read_as),
            false => (text.read_as, ""),
        };
        Some(Sequenced {
            lead,
            first,
            second,
            before_first,
            before_second,
        })
    }

    /// The tokens with both steps in order.
    ///
    /// * `span`: the place of the words that say so
    pub(super) fn in_order(
        &self,
        tokens: &[Token],
        sequenced: &Sequenced<'a>,
        span: Span,
    ) -> Result<Tokens, Refusal> {
        let mut ordered = Tokens::new();
        let next = self.model.sequence.next;
        let pieces = [
            ("", &sequenced.lead),
            (sequenced.before_first, &sequenced.first),
            (next, &(0..0)),
            (sequenced.before_second, &sequenced.second),
        ];
        for (words, piece) in pieces {
            self.write_words(words, span, &mut ordered)?;
            for token in tokens.get(piece.clone()).unwrap_or_default() {
                push(&mut ordered, token.kind, token.span)?;
            }
        }
        Ok(ordered)
    }

    /// The steps of a sentence that begins with the words before one of them: that one, and the other one, which begins
    /// with its verb or behind the last comma before it. `None` also if the two are the same and the verb is asked for.
    fn both(
        &self,
        tokens: &[Token],
        from: usize,
        end: StepEnd,
    ) -> Option<(Range<usize>, Range<usize>)> {
        let described = tokens.get(from..)?.iter().position(Token::is_group)?;
        let described = from.checked_add(described)?;
        let mut behind = described.checked_add(1)?..tokens.len();
        let verb = behind.find(|index| tokens.get(*index).is_some_and(|token| self.ends(token)))?;
        let mut before = (described..verb).rev();
        let comma =
            before.find(|index| tokens.get(*index).is_some_and(|token| self.is_comma(token)));
        let behind_comma = comma.map_or(verb, |comma| comma.saturating_add(1));
        // "Next to the blue one, on its left".
        let between = tokens.get(behind_comma..verb)?;
        let is_side = |token: &Token| self.is_one_of(self.model.compounds.sides, token);
        let is_relation = between.iter().any(is_side) && !between.iter().any(Token::is_group);
        match end {
            StepEnd::Comma if is_relation => None,
            StepEnd::Comma => Some((from..comma.unwrap_or(verb), behind_comma..tokens.len())),
            StepEnd::Verb => (behind_comma < verb).then_some((from..verb, verb..tokens.len())),
        }
    }

    /// How many tokens stand before the verb of a step, or none if it has no verb.
    fn lead(&self, step: &[Token]) -> Option<usize> {
        let described = step.iter().position(Token::is_group)?;
        let verb = step
            .get(..described)?
            .iter()
            .rposition(|token| self.ends(token));
        Some(verb.unwrap_or(0))
    }

    /// Whether these are the words of one step: no other one begins behind its first description.
    fn is_one_step(&self, tokens: &[Token]) -> Option<bool> {
        let described = tokens.iter().position(Token::is_group)?;
        let mut behind = tokens.get(described..)?.iter();
        Some(!behind.any(|token| self.ends(token)))
    }

    /// The index before a comma or a full stop.
    fn before_mark(&self, tokens: &[Token], at: usize) -> Option<usize> {
        let last = at.checked_sub(1)?;
        let token = tokens.get(last)?;
        let is_mark = self.is_comma(token) || self.is(token, ".");
        Some(if is_mark { last } else { at })
    }
}

/// Whether these words say in which order two steps are carried out.
pub(crate) fn says_order(model: &Model<'_>, words: &str) -> bool {
    let sequence = model.sequence;
    let mut texts = sequence.later.iter().chain(sequence.earlier);
    texts.any(|text| letters(words).eq(text.text.chars()))
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;
    use std::format;

    use super::*;
    use crate::fixture;
    use crate::model::{Arrangements, Sequence};

    fn model() -> Model<'static> {
        let text = |text, read_as| SequenceText::new().with_text(text).with_read_as(read_as);
        let later = [text("before", ""), text("before putting", "put")];
        let earlier = [
            text("after", ""),
            text("but first", "").with_is_afterthought(true),
            text("near putting", "put"),
            text("once", ""),
        ];
        let sequence = Sequence::new()
            .with_later(Box::leak(Box::new(later)))
            .with_earlier(Box::leak(Box::new(earlier)))
            .with_first_words(&["after", "before", "but", "near", "once"])
            .with_next("then");
        let ends = Arrangements::new().with_ends(&[".", "put", "then"]);
        let model = fixture::with_table().with_arrangements(ends);
        let model = model.with_sequence(sequence);
        assert_eq!(model.check(), Ok(()));
        model
    }

    #[test]
    fn steps_are_read_in_the_order_in_which_they_are_carried_out() {
        let own = "put red on green";
        let other = "put lego on small";
        for (said, order) in [
            (format!("before {own} , {other}"), [other, own]),
            (format!("before {own} {other}"), [other, own]),
            (format!("after {own} , {other}"), [own, other]),
            (format!("after {own} then {other}"), [own, other]),
            (
                format!("before putting red on green , {other}"),
                [other, own],
            ),
            (format!("{other} before {own}"), [other, own]),
            (format!("{other} , before {own}"), [other, own]),
            (format!("{other} after {own}"), [own, other]),
            (format!("{other} near putting red on green"), [own, other]),
            (format!("{other} , but first {own}"), [own, other]),
            (format!("the {other} once {own}"), [own, other]),
            // "Please".
            (format!("before {own} , the {other}"), [other, own]),
        ] {
            let [first, second] = order;
            let the = if said.contains("the") { "the " } else { "" };
            let meant = fixture::parse(&model(), &format!("{the}{first} then {second}"));
            assert!(meant.is_ok(), "{meant:?}");
            assert_eq!(fixture::parse(&model(), &said), meant, "{said}");
        }
    }

    #[test]
    fn of_more_than_two_steps_the_order_is_unclear() {
        for sentence in [
            "before put red on green then put lego on small",
            "before put red on green",
            "before put red on green , put lego on small then put red on lego",
            "put red on green then put lego on small after put red on lego",
            "put red on green after put red on lego then put lego on small",
            "put red on green after put red on lego before put lego on small",
            "but first put red on green , put lego on small",
        ] {
            let refusal = fixture::parse(&model(), sentence).unwrap_err();
            assert_eq!(refusal.kind(), "unclear_words", "{sentence}");
        }
        for sentence in ["put red on green before", "put red on green before lego"] {
            let refusal = fixture::parse(&model(), sentence).unwrap_err();
            assert_eq!(refusal.kind(), "unknown_word", "{sentence}");
        }
    }
}
