//! Pronouns: "put the red block on the blue one, then put it behind the white one".
//!
//! A sentence with a pronoun is read in two ways, with the pronoun as a word like any other ("take the
//! red block and put it on the blue one"), and with a group of concept words in its place. The network
//! sees the same token for every group, so that nothing has to be learned to understand the second
//! way, and decides by how much sense the words make. The group means what the step before moved.

use crate::dsl::{Extreme, Filters, Program, Property};
use crate::model::{Model, Pronoun};

/// The pronoun that a word may be.
///
/// * `word`: index into [`Model::words`]
pub(super) fn pronoun<'a>(model: &Model<'a>, word: u16) -> Option<&'a Pronoun> {
    let pronouns = model.pronouns;
    let found = pronouns.binary_search_by_key(&word, |pronoun| pronoun.word);
    pronouns.get(found.ok()?)
}

/// What a pronoun means behind these steps: how the object that the last one moves is described, if
/// it moves a single one, and this still describes it once it is moved.
pub(super) fn antecedent(program: &Program) -> Option<Filters> {
    let object = &program.steps().last()?.object;
    let lasts = match object.filters().choice() {
        Some(Property::Extreme(extreme)) => !matches!(extreme, Extreme::Action(_)),
        Some(Property::Ranked(_)) => false,
        _ => true,
    };
    let is_single = object.filters().quantifier().is_none() && object.except().is_none();
    (is_single && lasts && object.relations().is_empty()).then_some(*object.filters())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MAX_READINGS;
    use crate::fixture::{self, parse};
    use crate::language::reader::Reading;
    use crate::language::{Reader, Span, TokenKind};
    use crate::refusal::Refusal;

    /// A model in which "the" is a pronoun.
    fn with_pronoun(model: Model<'static>, owner: Option<&str>) -> Model<'static> {
        let word = |text| {
            let found = model.words.iter().position(|word| word.text == text);
            u16::try_from(found.unwrap()).unwrap()
        };
        let pronoun = Pronoun {
            word: word("the"),
            owner: owner.map(word),
        };
        let model = model.with_pronouns(std::vec![pronoun].leak());
        assert_eq!(model.check(), Ok(()));
        model
    }

    #[test]
    fn a_pronoun_means_what_the_step_before_moves() {
        let model = with_pronoun(fixture::model(), None);
        for (sentence, meant) in [
            (
                "put lego red on green then put the right small",
                "put lego red on green then put lego red right small",
            ),
            (
                "put lego red on green then put small right the",
                "put lego red on green then put small right lego red",
            ),
            (
                "put red on green then put the right small then put the on lego",
                "put red on green then put red right small then put red on lego",
            ),
            // A word like any other.
            (
                "put red on green then put small on lego the",
                "put red on green then put small on lego",
            ),
            (
                "put red on green then put the small on lego",
                "put red on green then put small on lego",
            ),
            // What is the largest stays the largest.
            (
                "put largest on green then put the right small",
                "put largest on green then put largest right small",
            ),
        ] {
            assert_eq!(parse(&model, sentence), parse(&model, meant), "{sentence}");
            assert!(parse(&model, meant).is_ok(), "{meant}");
        }
    }

    #[test]
    fn behind_a_step_that_puts_a_pronoun_is_of_the_next_one() {
        let mut model = with_pronoun(fixture::model(), None);
        let readings = |model: &Model<'_>, sentence| read(model, sentence, 0).1;
        for sentence in ["put red on green put the", "put red on green then put the"] {
            assert_eq!(readings(&model, sentence), 2, "{sentence}");
        }
        let put = model.words.iter().position(|word| word.text == "put");
        let put = u16::try_from(put.unwrap()).unwrap();
        model.placing = std::vec![put].leak();
        model.arrangements.ends = &["then"];
        assert_eq!(model.check(), Ok(()));
        for sentence in [
            "put red on green put the",
            "then put red on green then put the",
            "put red right green on lego then put red on green then put the",
            "put small red right green then put the",
        ] {
            let (kinds, readings) = read(&model, sentence, 0);
            assert_eq!(readings, 1, "{sentence}");
            assert_eq!(kinds.last(), Some(&TokenKind::Pronoun), "{sentence}");
        }
        // No such word before the descriptions, or before the pronoun, or one of an earlier step.
        for sentence in [
            "red on green then put the",
            "put red on green on the",
            "put small on lego then red on green put the",
            "put small then red on green put the",
        ] {
            assert_eq!(readings(&model, sentence), 2, "{sentence}");
        }
        model.ordinals.articles = &["the"];
        assert_eq!(readings(&model, "put red on green put the"), 2);
        model.placing = std::vec![put; 2].leak();
        assert!(model.check().is_err());
    }

    fn unclear(step: u8, start: u16) -> Refusal {
        let span = Span {
            start,
            end: start + 3,
        };
        Refusal::UnclearPronoun { step, span }
    }

    #[test]
    fn a_pronoun_that_means_nothing_is_refused() {
        let model = with_pronoun(fixture::related(), None);
        for (sentence, refusal) in [
            // Where the object is not any more.
            (
                "put small above green on red then put the on lego",
                unclear(1, 38),
            ),
            (
                "put topmost red on green then put the on lego",
                unclear(1, 34),
            ),
            // Several objects.
            ("put all red on green then put the on lego", unclear(1, 30)),
            // Onto itself.
            (
                "put red lego on green then put the on lego red",
                unclear(1, 31),
            ),
        ] {
            assert_eq!(parse(&model, sentence), Err(refusal), "{sentence}");
        }
        for sentence in [
            "put the on green then put red on lego",
            "put red on green then put the on the",
            "put red on the",
        ] {
            let refusal = parse(&model, sentence).unwrap_err();
            assert_eq!(refusal.kind(), "incomplete_step", "{sentence}");
        }
    }

    #[test]
    fn behind_a_conjunction_a_pronoun_is_a_word_like_any_other() {
        let mut model = with_pronoun(fixture::model(), None);
        let sentence = "put red on green then put near right the";
        let (_, readings) = read(&model, sentence, 0);
        assert_eq!(readings, 2);
        model.conjunctions = &["near right"];
        assert_eq!(model.check(), Ok(()));
        let (_, readings) = read(&model, sentence, 0);
        assert_eq!(readings, 1);
        let other = "put red on green then put right the";
        let (_, readings) = read(&model, other, 0);
        assert_eq!(readings, 2);
    }

    #[test]
    fn an_unknown_pronoun_is_a_word_like_any_other() {
        let refusal =
            parse(&fixture::model(), "put red on green then put the on lego").unwrap_err();
        assert_eq!(refusal.kind(), "incomplete_step");
    }

    fn read(model: &Model<'_>, sentence: &str, number: usize) -> (std::vec::Vec<TokenKind>, usize) {
        let reading = Reading {
            number,
            is_simplified: false,
        };
        let mut reader = Reader::nth(sentence, reading).unwrap();
        while reader.advance(model, sentence).unwrap() {}
        let kinds = reader.tokens().iter().map(|token| token.kind);
        (kinds.collect(), reader.readings())
    }

    #[test]
    fn a_possessive_pronoun_is_read_as_two_words() {
        let model = with_pronoun(fixture::model(), Some("near"));
        let sentence = "red on green put small the right";
        let (plain, readings) = read(&model, sentence, 0);
        assert_eq!(readings, 2);
        let (other, _) = read(&model, sentence, 1);
        assert_eq!(plain[..5], other[..5]);
        let near = model.words.iter().position(|word| word.text == "near");
        let owner = TokenKind::Word(u16::try_from(near.unwrap()).unwrap());
        assert_eq!(other[5..7], [TokenKind::Pronoun, owner]);
        assert_eq!(plain[6..], other[7..]);
    }

    #[test]
    fn only_so_many_pronouns_have_two_readings() {
        let model = with_pronoun(fixture::model(), None);
        // Nothing was moved before the first, and one follows the second.
        let (_, readings) = read(&model, "red on the green the the", 0);
        assert_eq!(readings, 2);
        let sentence = "red on green put the put the put the put the put the";
        let (kinds, readings) = read(&model, sentence, MAX_READINGS - 1);
        assert_eq!(readings, MAX_READINGS);
        let pronouns = kinds.iter().filter(|kind| **kind == TokenKind::Pronoun);
        assert_eq!(pronouns.count(), 4);
    }
}
