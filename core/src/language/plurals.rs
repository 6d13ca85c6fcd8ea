//! Nouns and their plurals: "the red blocks" are all red blocks.
//!
//! Nothing is learned here: the model lists the plurals ([`crate::model::Several`]), and the nouns ([`crate::model::Ordinals`]).

use super::phrases::PhraseMatcher;
use super::tokens::Tokens;
use super::words::find;
use super::{Token, TokenKind};
use crate::dsl::{Filters, Property, Quantifier};
use crate::refusal::Refusal;

/// A number of objects, as a noun says it.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Number {
    One,
    Several,
}

impl PhraseMatcher<'_, '_> {
    /// The description at a token as one of all objects that fit, and the noun of one of them, if it has an article and a
    /// noun in the plural.
    pub(super) fn all_of(&self, tokens: &[Token], at: usize) -> Option<(Filters, u16)> {
        let mut filters = *tokens.get(at)?.filters()?;
        let noun = tokens.get(at.checked_add(1)?)?;
        let is_plain = filters.choice().is_none() && !filters.concepts().is_empty();
        if !is_plain || !self.is_article(tokens, at) || self.number(noun) != Some(Number::Several) {
            return None;
        }
        let plurals = self.model.several.plurals;
        let (_, plural) = find(plurals, self.text(noun), |plural| plural.text)?;
        filters.add(Property::Quantifier(Quantifier::All)).ok()?;
        Some((filters, plural.word))
    }

    /// Puts such a description in place of the one at a token.
    pub(super) fn put_all_of(
        tokens: &mut Tokens,
        at: usize,
        (filters, noun): (Filters, u16),
    ) -> Result<(), Refusal> {
        let pair = at..at.saturating_add(2);
        let kinds = [TokenKind::Group(filters), TokenKind::Word(noun)];
        let places = tokens.get_mut(pair).ok_or(Refusal::InvalidModel)?;
        for (token, kind) in places.iter_mut().zip(kinds) {
            token.kind = kind;
        }
        Ok(())
    }

    /// Whether a token is a noun, and in which number.
    pub(super) fn number(&self, token: &Token) -> Option<Number> {
        let nouns = self.model.ordinals.nouns;
        if self.is_one_of(nouns, token) {
            return Some(Number::One);
        }
        let plurals = self.model.several.plurals;
        let (_, plural) = find(plurals, self.text(token), |plural| plural.text)?;
        let word = self.model.words.get(usize::from(plural.word))?;
        let is_noun = find(nouns, word.text, |noun| noun).is_some();
        (!token.is_group() && is_noun).then_some(Number::Several)
    }
}

#[cfg(test)]
mod tests {
    use crate::fixture::{self, parse};

    #[test]
    fn a_plural_with_an_article_means_all() {
        let model = fixture::with_exceptions();
        let all = parse(&model, "put all red nears on lego");
        assert_eq!(parse(&model, "put the red nears on lego"), all);
        assert!(all.is_ok());
        for (sentence, kind) in [
            ("put red nears on lego", "unknown_word"),
            ("put the nears on lego", "unknown_word"),
        ] {
            assert_eq!(
                parse(&model, sentence).unwrap_err().kind(),
                kind,
                "{sentence}"
            );
        }
    }
}
