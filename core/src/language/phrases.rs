//! The texts that a model lists, found among the tokens of a sentence.

use core::ops::Range;

use super::tokens::{Tokens, push};
use super::words::{find, letters, word};
use super::{Span, Token, TokenKind};
use crate::dsl::Filters;
use crate::model::{
    CompoundText, CountedFrom, DistanceNumber, DistanceShift, Model, Rephrased, SequenceText,
};
use crate::refusal::Refusal;

/// Compares the tokens of a sentence with texts: words in lower case with one space in between.
#[derive(Clone, Copy)]
pub(super) struct PhraseMatcher<'s, 'a> {
    pub(super) model: &'s Model<'a>,
    pub(super) sentence: &'s str,
}

impl<'a> PhraseMatcher<'_, 'a> {
    /// Whether a token is one of these words, which are sorted.
    pub(super) fn is_one_of(&self, words: &[&str], token: &Token) -> bool {
        let text = match token.kind {
            TokenKind::Word(index) => self.known(index),
            TokenKind::Unknown => self.text(token),
            TokenKind::Group(_) | TokenKind::Pronoun | TokenKind::Compound { .. } => return false,
        };
        find(words, text, |word| word).is_some()
    }

    /// How many tokens the text has, if these begin with it.
    pub(super) fn begins_with(&self, tokens: &[Token], text: &str) -> Option<usize> {
        let mut tokens = tokens.iter();
        let mut count = 0_usize;
        for word in parts(text) {
            let token = tokens.next()?;
            // A plural behind "all" is read as a singular.
            let is_said = || {
                let is_word = matches!(token.kind, TokenKind::Word(_));
                is_word && letters(self.text(token)).eq(word.chars())
            };
            if !self.is(token, word) && !is_said() {
                return None;
            }
            count = count.saturating_add(1);
        }
        Some(count)
    }

    /// The longest of these texts, which are sorted, with which the tokens begin, and how many it has.
    pub(super) fn longest<'t, T>(&self, tokens: &[Token], texts: &'t [T]) -> Option<(usize, &'t T)>
    where
        TextList<'t>: From<&'t [T]>,
    {
        let (length, index) = self.longest_of(tokens, texts.len(), texts.into())?;
        Some((length, texts.get(index)?))
    }

    /// The same by index, once for all kinds of texts: each would take 2 KB of flash.
    #[inline(never)]
    fn longest_of(
        &self,
        tokens: &[Token],
        count: usize,
        list: TextList<'_>,
    ) -> Option<(usize, usize)> {
        let text = |index| list.get(index).unwrap_or_default();
        // No text begins with a description.
        let first = tokens.first().filter(|token| !token.is_group())?;
        let mut texts = 0..count;
        texts.start = partition_point(&texts, |each| self.is_behind(first, text(each)));
        if texts.is_empty() || !self.is(first, part(text(texts.start), 0)) {
            return None;
        }
        let mut longest = None;
        // Those that begin with the tokens so far are together.
        for (index, token) in tokens.iter().enumerate() {
            texts.start = partition_point(&texts, |each| {
                self.is_behind(token, part(text(each), index))
            });
            texts.end = partition_point(&texts, |each| self.is(token, part(text(each), index)));
            let length = index.saturating_add(1);
            // That which ends here stands first.
            if texts.is_empty() {
                return longest;
            }
            if parts(text(texts.start)).nth(length).is_none() {
                longest = Some((length, texts.start));
            }
        }
        longest
    }

    /// How many tokens the text has, if these end with it.
    pub(super) fn ends_with(&self, tokens: &[Token], text: &str) -> Option<usize> {
        let end = text.bytes().rposition(|byte| byte == b' ');
        let last = end.map_or(Some(text), |end| text.get(end.saturating_add(1)..))?;
        if !self.is(tokens.last()?, last) {
            return None;
        }
        let length = parts(text).count();
        let from = tokens.len().checked_sub(length)?;
        self.begins_with(tokens.get(from..)?, text)
    }

    /// The clause that these tokens are in: from behind the words before them that end a list, a verb for instance,
    /// to before the next ones.
    pub(super) fn clause(&self, tokens: &[Token], said: &Range<usize>) -> Option<Range<usize>> {
        let before = tokens
            .get(..said.start)?
            .iter()
            .rposition(|token| self.ends(token));
        let mut behind = tokens.get(said.end..)?.iter();
        let length = behind.position(|token| self.ends(token));
        Some(Range {
            start: before.map_or(0, |end| end.saturating_add(1)),
            end: length.map_or(tokens.len(), |length| said.end.saturating_add(length)),
        })
    }

    /// Whether a list or a clause ends before a token, a verb for instance.
    pub(super) fn ends(&self, token: &Token) -> bool {
        self.is_one_of(self.model.arrangements.ends, token)
    }

    pub(super) fn is_comma(&self, token: &Token) -> bool {
        self.is(token, ",")
    }

    /// The index behind a comma at this token, or that of the token.
    pub(super) fn behind_comma(&self, tokens: &[Token], at: usize) -> usize {
        let is_comma = tokens.get(at).is_some_and(|token| self.is_comma(token));
        at.saturating_add(usize::from(is_comma))
    }

    /// Whether a token is this word.
    pub(super) fn is(&self, token: &Token, text: &str) -> bool {
        match token.kind {
            TokenKind::Word(index) => self.known(index) == text,
            // "Each" in "each other" is read as a group.
            TokenKind::Unknown | TokenKind::Group(_) => letters(self.text(token)).eq(text.chars()),
            TokenKind::Pronoun | TokenKind::Compound { .. } => false,
        }
    }

    /// Whether this text comes before a token's in the order of letters.
    pub(super) fn is_behind(&self, token: &Token, text: &str) -> bool {
        match token.kind {
            TokenKind::Word(index) => text < self.known(index),
            TokenKind::Unknown | TokenKind::Group(_) => text.chars().lt(letters(self.text(token))),
            // No text has one.
            TokenKind::Pronoun | TokenKind::Compound { .. } => true,
        }
    }

    /// Puts words of the model or of its lexicon in place of these tokens, none for an empty text; the index of the token
    /// behind them. In place: a copy of the tokens would take 2 KB of the stack.
    pub(super) fn replace(
        &self,
        tokens: &mut Tokens,
        replaced: &Range<usize>,
        words: &str,
        span: Span,
    ) -> Result<usize, Refusal> {
        let words = || parts(words).filter(|text| !text.is_empty());
        let start = replaced.start;
        let behind = Self::resize(tokens, replaced, words().count(), span)?;
        for (place, text) in tokens.iter_mut().skip(start).zip(words()) {
            let kind = self.read(text).ok_or(Refusal::InvalidModel)?;
            *place = Token { kind, span };
        }
        Ok(behind)
    }

    /// Puts so many tokens in place of these, unknown words where there are more; the index of the token behind them.
    pub(super) fn resize(
        tokens: &mut Tokens,
        replaced: &Range<usize>,
        count: usize,
        span: Span,
    ) -> Result<usize, Refusal> {
        let Range { start, end } = *replaced;
        let behind = start.saturating_add(count);
        let rest = tokens.len().saturating_sub(end);
        let length = behind.saturating_add(rest);
        while tokens.len() < length {
            push(tokens, TokenKind::Unknown, span)?;
        }
        for index in 0..rest {
            // From behind, if there are more than before.
            let index = if behind > end {
                rest.saturating_sub(index.saturating_add(1))
            } else {
                index
            };
            let (from, to) = (end.saturating_add(index), behind.saturating_add(index));
            if let Some(&token) = tokens.get(from)
                && let Some(place) = tokens.get_mut(to)
            {
                *place = token;
            }
        }
        tokens.truncate(length);
        Ok(behind)
    }

    /// Appends words of the model; none for an empty text.
    pub(super) fn write_words(
        &self,
        words: &str,
        span: Span,
        tokens: &mut Tokens,
    ) -> Result<(), Refusal> {
        for text in parts(words).filter(|text| !text.is_empty()) {
            let index = word(self.model, text).ok_or(Refusal::InvalidModel)?;
            push(tokens, TokenKind::Word(index), span)?;
        }
        Ok(())
    }

    /// As what a text of the model is read: one of its words, or one of the lexicon, which describes an object.
    fn read(&self, text: &str) -> Option<TokenKind> {
        if let Some(index) = word(self.model, text) {
            return Some(TokenKind::Word(index));
        }
        let (_, entry) = find(self.model.lexicon, text, |entry| entry.text)?;
        let mut filters = Filters::new();
        // Empty filters have room.
        let _ = filters.add(entry.property);
        Some(TokenKind::Group(filters))
    }

    fn known(&self, index: u16) -> &'a str {
        let word = self.model.words.get(usize::from(index));
        word.map_or("", |word| word.text)
    }

    pub(super) fn text(&self, token: &Token) -> &str {
        token.span.of(self.sentence).unwrap_or_default()
    }
}

/// Sorted texts that a model lists, by themselves or with what they mean.
#[derive(Clone, Copy)]
pub(super) enum TextList<'t> {
    Plain(&'t [&'t str]),
    Counted(&'t [CountedFrom<'t>]),
    Compound(&'t [CompoundText<'t>]),
    Sequence(&'t [SequenceText<'t>]),
    Number(&'t [DistanceNumber<'t>]),
    Shift(&'t [DistanceShift<'t>]),
    Rephrased(&'t [Rephrased<'t>]),
}

impl<'t> TextList<'t> {
    fn get(self, index: usize) -> Option<&'t str> {
        match self {
            Self::Plain(texts) => texts.get(index).copied(),
            Self::Counted(texts) => texts.get(index).map(|counted| counted.text),
            Self::Compound(texts) => texts.get(index).map(|said| said.text),
            Self::Sequence(texts) => texts.get(index).map(|said| said.text),
            Self::Rephrased(texts) => texts.get(index).map(|said| said.text),
            Self::Number(texts) => texts.get(index).map(|number| number.text),
            Self::Shift(texts) => texts.get(index).map(|shift| shift.text),
        }
    }
}

impl<'t> From<&'t [&'t str]> for TextList<'t> {
    fn from(texts: &'t [&'t str]) -> Self {
        Self::Plain(texts)
    }
}

impl<'t> From<&'t [CountedFrom<'t>]> for TextList<'t> {
    fn from(texts: &'t [CountedFrom<'t>]) -> Self {
        Self::Counted(texts)
    }
}

impl<'t> From<&'t [CompoundText<'t>]> for TextList<'t> {
    fn from(texts: &'t [CompoundText<'t>]) -> Self {
        Self::Compound(texts)
    }
}

impl<'t> From<&'t [SequenceText<'t>]> for TextList<'t> {
    fn from(texts: &'t [SequenceText<'t>]) -> Self {
        Self::Sequence(texts)
    }
}

impl<'t> From<&'t [DistanceNumber<'t>]> for TextList<'t> {
    fn from(texts: &'t [DistanceNumber<'t>]) -> Self {
        Self::Number(texts)
    }
}

impl<'t> From<&'t [DistanceShift<'t>]> for TextList<'t> {
    fn from(texts: &'t [DistanceShift<'t>]) -> Self {
        Self::Shift(texts)
    }
}

impl<'t> From<&'t [Rephrased<'t>]> for TextList<'t> {
    fn from(texts: &'t [Rephrased<'t>]) -> Self {
        Self::Rephrased(texts)
    }
}

/// The first of these indices for which this does not hold; it holds for none behind that.
fn partition_point(indices: &Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let Range { mut start, mut end } = *indices;
    while start < end {
        let middle = start.midpoint(end);
        if holds(middle) {
            start = middle.saturating_add(1);
        } else {
            end = middle;
        }
    }
    start
}

/// A word of a text with one space in between; empty behind the last.
fn part(text: &str, index: usize) -> &str {
    parts(text).nth(index).unwrap_or_default()
}

/// The words of a text with one space in between.
pub(super) fn parts(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    core::iter::from_fn(move || {
        let text = rest?;
        let end = text.bytes().position(|byte| byte == b' ');
        rest = end.and_then(|end| text.get(end.saturating_add(1)..));
        text.get(..end.unwrap_or(text.len()))
    })
}
