//! The texts that a model lists, found among the tokens of a sentence.

use super::tokens::{Tokens, push};
use super::words::{find, letters, word};
use super::{Span, Token, TokenKind};
use crate::model::Model;
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
            if !self.is(tokens.next()?, word) {
                return None;
            }
            count = count.saturating_add(1);
        }
        Some(count)
    }

    /// The longest of these texts, which are sorted, with which the tokens begin, and how many it has.
    pub(super) fn longest<'t, T>(
        &self,
        tokens: &[Token],
        texts: &'t [T],
        text: fn(&T) -> &str,
    ) -> Option<(usize, &'t T)> {
        let first = tokens.first()?;
        let from = texts.partition_point(|each| self.is_behind(first, text(each)));
        let mut texts = texts.get(from..)?;
        if !self.is(first, part(text(texts.first()?), 0)) {
            return None;
        }
        let mut longest = None;
        // Those that begin with the tokens so far are together.
        for (index, token) in tokens.iter().enumerate() {
            let from = texts.partition_point(|each| self.is_behind(token, part(text(each), index)));
            texts = texts.get(from..)?;
            let end = texts.partition_point(|each| self.is(token, part(text(each), index)));
            texts = texts.get(..end)?;
            let length = index.saturating_add(1);
            // That which ends here stands first.
            let Some(first) = texts.first() else {
                return longest;
            };
            if parts(text(first)).nth(length).is_none() {
                longest = Some((length, first));
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
            TokenKind::Unknown => text.chars().lt(letters(self.text(token))),
            // None stands before a list.
            TokenKind::Group(_) | TokenKind::Pronoun | TokenKind::Compound { .. } => true,
        }
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

    fn known(&self, index: u16) -> &'a str {
        let word = self.model.words.get(usize::from(index));
        word.map_or("", |word| word.text)
    }

    pub(super) fn text(&self, token: &Token) -> &str {
        token.span.of(self.sentence).unwrap_or_default()
    }
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
