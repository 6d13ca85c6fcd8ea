//! Values of one object that stand apart: "the small block that is red", "the small and red block".
//!
//! They are joined to one group, as if they had been said together, "the small red block"; those directly
//! beside each other last, since the objects of a list are, too ("a tower of red, small and blue"). Nothing is
//! learned here: the model lists what may stand between ([`crate::model::Apart`]).

use super::phrases::PhraseMatcher;
use super::tokens::{Tokens, join, push};
use super::{Token, TokenKind};
use crate::refusal::Refusal;

/// Where a group joins another one.
#[derive(Clone, Copy)]
pub(super) struct Joint {
    /// Index of the group that it joins, or of the noun that it is put before.
    into: usize,
    /// Index of the first word in between.
    from: usize,
    /// Index of the group that joins.
    group: usize,
}

impl Joint {
    /// Index of the token behind the group that joins.
    pub(super) const fn behind(self) -> usize {
        self.group.saturating_add(1)
    }
}

impl PhraseMatcher<'_, '_> {
    /// How the group at this token joins what stands before it.
    ///
    /// * `directly`: whether only another group may stand before what is in between
    pub(super) fn joint(&self, tokens: &[Token], group: usize, directly: bool) -> Option<Joint> {
        let filters = tokens.get(group)?.filters()?;
        if filters.choice().is_some() {
            return None;
        }
        let before = tokens.get(..group)?;
        let apart = self.model.apart;
        let texts = if directly {
            apart.between
        } else {
            apart.phrases
        };
        let lengths = texts.iter().filter_map(|text| self.ends_with(before, text));
        let from = group.checked_sub(lengths.max()?)?;
        let last = from.checked_sub(1)?;
        let is_group = |index: usize| {
            tokens
                .get(index)
                .is_some_and(|token| token.filters().is_some())
        };
        if directly || is_group(last) {
            let joint = Joint {
                into: last,
                from,
                group,
            };
            return is_group(last).then_some(joint);
        }
        let noun = tokens
            .get(last)
            .filter(|token| matches!(token.kind, TokenKind::Word(_)))?;
        let first = last.checked_sub(1).filter(|index| is_group(*index));
        let unknown = |token: &Token| token.kind == TokenKind::Unknown;
        match first {
            Some(into) => Some(Joint { into, from, group }),
            // What the network knows it reads itself: "the block that is red".
            None => {
                let is_new = tokens.get(from..group)?.iter().any(unknown) && !unknown(noun);
                is_new.then_some(Joint {
                    into: last,
                    from,
                    group,
                })
            }
        }
    }

    /// Whether one of the words in between is unknown, so that the group can only join.
    pub(super) fn must_join(tokens: &[Token], joint: Joint) -> bool {
        let between = tokens.get(joint.from..joint.group).unwrap_or_default();
        between.iter().any(|token| token.kind == TokenKind::Unknown)
    }

    /// The tokens with the group joined, and the index of the one that it is now part of.
    pub(super) fn joined(
        &self,
        tokens: &[Token],
        joint: Joint,
    ) -> Result<(Tokens, usize), Refusal> {
        let mut joined = Tokens::new();
        let group = tokens.get(joint.group).ok_or(Refusal::InvalidModel)?;
        for (index, token) in tokens.iter().enumerate() {
            if index == joint.into {
                if token.filters().is_some() {
                    let whole = join(self.model, token, group)?;
                    push(&mut joined, whole.kind, whole.span)?;
                    continue;
                }
                push(&mut joined, group.kind, group.span)?;
            }
            if !(joint.from..=joint.group).contains(&index) {
                push(&mut joined, token.kind, token.span)?;
            }
        }
        Ok((joined, joint.into))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::model::Apart;

    const APART: Apart<'static> = Apart::new()
        .with_between(&["near", ", near"])
        .with_phrases(&["near", "size is", "whose hue is", "near whose size is"]);

    fn parse(sentence: &str) -> Result<std::string::String, Refusal> {
        let model = fixture::model().with_apart(APART);
        assert_eq!(model.check(), Ok(()));
        fixture::parse(&model, sentence)
    }

    #[test]
    fn values_that_stand_apart_are_one_description() {
        for (sentence, meant) in [
            ("put lego near red on green", "put lego red on green"),
            ("put lego , near red on green", "put lego red on green"),
            ("put lego the near red on green", "put lego red on green"),
            (
                "put lego the whose hue is red on green",
                "put lego red on green",
            ),
            ("put red on the whose hue is green", "put red on green"),
            (
                "put the whose hue is red near whose size is small on lego the Whose Hue is green",
                "put red small on lego green",
            ),
        ] {
            assert_eq!(parse(sentence), parse(meant), "{sentence}");
            assert!(parse(meant).is_ok(), "{meant}");
        }
    }

    #[test]
    fn values_of_one_type_do_not_join() {
        let refusal = parse("put red the whose hue is green on small").unwrap_err();
        assert_eq!(refusal.kind(), "conflicting_values");
    }

    #[test]
    fn words_that_join_nothing_are_unknown() {
        for sentence in [
            "put red on green whose",
            "put red on lego then put then the whose hue is the green",
            "whose hue is red on green",
            "put red the the whose hue on green",
        ] {
            let refusal = parse(sentence).unwrap_err();
            assert_eq!(refusal.kind(), "unknown_word", "{sentence}");
        }
    }
}
