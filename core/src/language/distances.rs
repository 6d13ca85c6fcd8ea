//! How far from the reference an object is put: "two centimetres to the left of the blue block", "to its left,
//! 2 cm away", "5 cm from the blue block"; or from where it is, "5 cm to the left".
//!
//! The words of a distance are left out, so that the network reads "to the left of the blue block", and the
//! distance is kept with its place; where the step that it stands in puts an object beside another one, it is
//! the step's. Nothing is learned here: the model lists what is said ([`crate::model::Distances`]).

use core::num::NonZeroU16;
use core::ops::Range;

use super::compounds::mark;
use super::phrases::{PhraseMatcher, parts};
use super::tokens::{Tokens, span_of};
use super::words::{find, letters, next_word};
use super::{Span, Token, TokenKind};
use crate::dsl::{Filters, Property};
use crate::model::{Distances, Model};
use crate::refusal::Refusal;

/// A distance that was left out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distance {
    /// Index of the token before which it stood.
    before: u8,
    /// Whether a clause ends behind it, so that it belongs to what stands before it.
    is_last: bool,
    /// Millimetres.
    pub(super) mm: NonZeroU16,
    /// Its place in the sentence.
    pub(super) span: Span,
}

impl Distance {
    /// Whether it stands among these tokens of the sentence.
    pub(super) fn is_in(&self, step: &Range<usize>) -> bool {
        let before = usize::from(self.before);
        // At the very beginning, there is no other step: none is lost.
        let at = before.saturating_sub(usize::from(self.is_last));
        step.contains(&at)
    }

    /// Whether it is that of the object which these groups of the step describe, from the first on: it stands
    /// directly before them, or behind a single one.
    ///
    /// * `tokens`: of the sentence
    pub(super) fn is_of(
        &self,
        reference: &Range<usize>,
        step: &Range<usize>,
        tokens: &[Token],
    ) -> bool {
        let before = tokens.get(step.start..self.before.into());
        let described = before.unwrap_or_default().iter();
        let described = described.filter(|token| token.is_group()).count();
        described == reference.start || (described == reference.end && reference.len() == 1)
    }
}

/// The words of a distance among the tokens.
pub(super) struct Said {
    words: Range<usize>,
    mm: NonZeroU16,
    is_last: bool,
    /// Whether no side is named: "from" belongs to the words.
    is_from: bool,
    /// The action in whose direction the object is moved from where it is: the direction belongs to the words.
    shift: Option<u8>,
}

impl PhraseMatcher<'_, '_> {
    /// The distance whose number is at a token, with all words that belong to it.
    pub(super) fn distance(&self, tokens: &[Token], at: usize) -> Option<Said> {
        let distances = self.model.distances;
        let (length, mm) = self.length(tokens.get(at..)?)?;
        let mut start = at;
        while let Some(length) = self.ends_with_any(tokens.get(..start)?, distances.before) {
            start = start.checked_sub(length)?;
        }
        let mut end = at.checked_add(length)?;
        let shift = self.shift(tokens, &(start..end));
        let rest = tokens.get(end..)?;
        let from = self.longest::<&str>(rest, distances.from);
        let behind = from.or_else(|| self.longest(rest, distances.behind));
        end = end.checked_add(behind.map_or(0, |(length, _)| length))?;
        let before = tokens.get(..start)?.last();
        let next = tokens.get(end);
        let has_size =
            |token: &Token| token.is_group() || self.is_one_of(self.model.ordinals.nouns, token);
        let is_size = before.is_some_and(|token| self.excludes_distance(token))
            || (from.is_none() && next.is_some_and(has_size));
        if is_size || self.follows_number(tokens, start) {
            return None;
        }
        // "2 cm away to the left", but not "2 cm from the left".
        let away = || from.is_none().then(|| self.shift(tokens, &(start..end)))?;
        if let Some(shift) = shift.or_else(away) {
            return Some(Said {
                words: shift.words,
                mm,
                is_last: false,
                is_from: false,
                shift: Some(shift.action),
            });
        }
        let is_last = from.is_none() && next.is_none_or(|token| self.separates(token));
        if is_last && before.is_some_and(|token| self.is_comma(token)) {
            start = start.checked_sub(1)?;
        }
        Some(Said {
            words: start..end,
            mm,
            is_last,
            is_from: from.is_some(),
            shift: None,
        })
    }

    /// Whether a word is none before or behind a distance.
    pub(super) fn excludes_distance(&self, token: &Token) -> bool {
        // "Every" in "the small every 2 cm" is read as a part of the description.
        let last = || letters(last_word(self.text(token)));
        let mut words = self.model.distances.unless.iter();
        words.any(|word| last().eq(word.chars()))
    }

    /// Whether a number stands before a token, or before a comma there: "5 cm" in "2,5 cm" is not 5 cm.
    fn follows_number(&self, tokens: &[Token], at: usize) -> bool {
        let before = tokens.get(..at).unwrap_or_default().iter().rev();
        let mut before = before.skip_while(|token| self.is_comma(token));
        before.next().is_some_and(|token| {
            let mut text = self.text(token);
            !token.is_group() && decimal(&mut text).is_some() && text.is_empty()
        })
    }

    /// Whether a distance begins with these tokens: "by" in "by 2 cm" is no place.
    pub(super) fn begins_distance(&self, tokens: &[Token]) -> bool {
        let mut rest = tokens;
        while let Some((length, _)) = self.longest::<&str>(rest, self.model.distances.before) {
            rest = rest.get(length..).unwrap_or_default();
        }
        self.length(rest).is_some()
    }

    /// Leaves the words of a distance out of the tokens; what is kept of it, and the index of the token behind
    /// them.
    pub(super) fn leave_out(
        &self,
        tokens: &mut Tokens,
        said: &Said,
    ) -> Result<(Distance, usize), Refusal> {
        let words = tokens.get(said.words.clone()).unwrap_or_default();
        let span = span_of(words).ok_or(Refusal::InvalidModel)?;
        let Range { start, end } = said.words;
        let mut behind;
        if let Some(action) = said.shift {
            let action = self.model.actions.get(usize::from(action));
            let phrase = action.ok_or(Refusal::InvalidModel)?.phrase;
            // The last of the words becomes the object itself.
            behind = self.replace(tokens, &(start..end.saturating_sub(1)), phrase, span)?;
            let mut itself = Filters::new();
            // It has room.
            let _ = itself.add(Property::Itself);
            let kind = TokenKind::Group(itself);
            *tokens.get_mut(behind).ok_or(Refusal::InvalidModel)? = Token { kind, span };
            behind = behind.saturating_add(1);
        } else {
            behind = self.replace(tokens, &said.words, "", span)?;
        }
        if said.is_from {
            let beside = self.model.distances.beside;
            let compound = self.beside(tokens, start, beside);
            let words = compound.map_or(beside, |(compound, _)| compound.read);
            behind = self.replace(tokens, &(start..start), words, span)?;
            if let Some((_, index)) = compound {
                mark(tokens, behind, index);
            }
        }
        let distance = Distance {
            // At most MAX_TOKENS.
            before: start as u8,
            is_last: said.is_last,
            mm: said.mm,
            span,
        };
        Ok((distance, behind))
    }

    /// How many tokens a number and its unit take at the beginning of these, and the length in millimetres;
    /// `None` for one that is not at least a millimetre.
    fn length(&self, tokens: &[Token]) -> Option<(usize, NonZeroU16)> {
        let distances = self.model.distances;
        let first = tokens.first()?;
        let mut digits = self.text(first);
        let decimal = match first.kind {
            // "2)" begins a step.
            TokenKind::Unknown | TokenKind::Word(_) => decimal(&mut digits),
            _ => None,
        };
        let (count, value, unit) = match decimal {
            Some(value) if digits.is_empty() => (2, value, self.text(tokens.get(1)?)),
            Some(value) => (1, value, digits),
            None => {
                let (count, number) = self.longest(tokens, distances.numbers)?;
                let unit = self.text(tokens.get(count)?);
                (count.checked_add(1)?, number.value, unit)
            }
        };
        let (_, unit) = find(distances.units, unit, |unit| unit.text)?;
        let mm = (value * unit.mm + 0.5) as u16;
        // Not one too long for the number.
        let mm = NonZeroU16::new(mm).filter(|mm| *mm < NonZeroU16::MAX)?;
        Some((count, mm))
    }

    /// How many tokens one of these texts has with which the tokens end.
    fn ends_with_any(&self, tokens: &[Token], texts: &[&str]) -> Option<usize> {
        let lengths = texts.iter().filter_map(|text| self.ends_with(tokens, text));
        lengths.max()
    }

    /// Whether a clause ends before a token, or it separates clauses.
    pub(super) fn separates(&self, token: &Token) -> bool {
        self.ends(token) || self.is_one_of(self.model.arrangements.between, token)
    }
}

/// The last of these words; empty if there is none.
fn last_word(words: &str) -> &str {
    let (mut last, mut from) = ("", 0);
    while let Some((word, span)) = next_word(words, from) {
        (last, from) = (word, span.end.into());
    }
    last
}

/// The unit of a word that is one, or a number and one, "2cm", or the shortest one for a number in words;
/// and how a person says where a side is.
pub(crate) fn unit_of<'a>(model: &Model<'a>, word: &str) -> Option<(&'a str, &'a str)> {
    let Distances { units, numbers, .. } = model.distances;
    let mut rest = word;
    let _ = decimal(&mut rest);
    let unit = find(units, rest, |unit| unit.text).map(|(_, unit)| unit);
    let is_said = |text: &str| parts(text).any(|part| letters(word).eq(part.chars()));
    let is_number = || numbers.iter().any(|number| is_said(number.text));
    let shortest = || units.iter().min_by_key(|unit| unit.text.len());
    let unit = unit.or_else(|| shortest().filter(|_| is_number()))?;
    let side = model.distances.sides.first()?;
    let side = model.actions.get(usize::from(*side))?;
    Some((unit.text, side.phrase))
}

/// The number in digits, "2" or "2.5", with which a text begins, and which is taken off it.
fn decimal(text: &mut &str) -> Option<f32> {
    let (mut value, mut unit) = (0.0_f32, 1.0_f32);
    let (mut length, mut has_point) = (0_usize, false);
    for byte in text.bytes() {
        match byte {
            b'0'..=b'9' => {
                value = 10.0 * value + f32::from(byte & 0x0f);
                unit = if has_point { 10.0 * unit } else { unit };
            }
            b'.' if length > 0 && !has_point => has_point = true,
            _ => break,
        }
        length = length.saturating_add(1);
    }
    *text = text.get(length..)?;
    (length > 0).then_some(value / unit)
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use super::decimal;
    use crate::fixture;

    /// How a sentence is understood, with shorter names.
    fn read(sentence: &str) -> String {
        fixture::read(&fixture::with_distances(), sentence)
            .replace("Unique(Filter(", "(")
            .replace(", Scene()))", ")")
    }

    #[test]
    fn a_distance_is_that_of_the_step_that_it_stands_in() {
        for sentence in [
            "put red 2 cm right green",
            "put red 20 mm right green",
            "put red 2cm right green",
            "put red 2.0 CM right green",
            "put red two cm right green",
            "put red by two cm right green",
            "put red by about two cm right green",
            "put red right green by 2 cm",
            "put red right green , two cm away",
            "put red right green 2 cm away",
        ] {
            let expected = "Action(MoveRight, (red), (green), Distance(0.020))";
            assert_eq!(read(sentence), expected, "{sentence}");
        }
        for (sentence, expected) in [
            (
                "put red half a cm right green",
                "Action(MoveRight, (red), (green), Distance(0.005))",
            ),
            (
                "put red one and a half inches right green",
                "Action(MoveRight, (red), (green), Distance(0.038))",
            ),
            (
                "put red 5 cm away from green",
                "Action(NextTo, (red), (green), Distance(0.050))",
            ),
            (
                "put red by green , 3 cm away",
                "Action(NextTo, (red), (green), Distance(0.030))",
            ),
            (
                "put red 1 cm right green then put lego right red by 5 cm",
                "Action(MoveRight, (red), (green), Distance(0.010))\n\
                 Action(MoveRight, (lego), (red), Distance(0.050))",
            ),
            (
                "put red right green by 1 cm then put lego on red",
                "Action(MoveRight, (red), (green), Distance(0.010))\n\
                 Action(MoveOn, (lego), (red))",
            ),
        ] {
            assert_eq!(read(sentence), expected, "{sentence}");
        }
    }

    #[test]
    fn a_distance_that_is_none_of_where_an_object_is_put_is_refused() {
        for sentence in [
            // Of the object, a size, or of the size of the reference.
            "put 2 cm red right green",
            "put the 2 cm red right green",
            "put red right the 2 cm green",
            "put red the\t2 cm right green",
            // Before the sentence, of nothing.
            "2 cm then put red right green",
            // Two of one step, or to two sides at once.
            "put red 2 cm right green by 3 cm",
            "put red 2 cm diagonally green",
            // Numbers in another notation.
            "put red 2,5 cm right green",
            "put red 2 5 cm right green",
            "put red right green , 2,5 cm away",
            // Vague, none, or too long.
            "put red some cm right green",
            "put red 0 cm right green",
            "put red 70000 mm right green",
            "put red cm right green",
            "put red 2 right green",
            "put red 2 metres right green",
            "put red .5 cm right green",
        ] {
            let kind = read(sentence);
            let is_refused = matches!(&*kind, "unclear_words" | "unknown_word" | "unsure");
            assert!(is_refused, "{sentence}: {kind}");
        }
    }

    #[test]
    fn more_distances_than_there_can_be_steps_are_refused() {
        let sentence = ["put red 2 cm right green"; 9].join(" then ");
        assert_eq!(read(&sentence), "unknown_word");
    }

    #[test]
    fn a_number_ends_where_its_digits_do() {
        for (text, expected, rest) in [
            ("2", Some(2.0), ""),
            ("12.5cm", Some(12.5), "cm"),
            ("1.2.3", Some(1.2), ".3"),
            ("3.", Some(3.0), ""),
            (".5", None, ".5"),
            ("cm", None, "cm"),
            ("", None, ""),
        ] {
            let mut left = text;
            assert_eq!(decimal(&mut left), expected, "{text}");
            assert_eq!(left, rest);
        }
    }
}
