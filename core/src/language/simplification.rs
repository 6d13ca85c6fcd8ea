//! What a sentence can do without: "um, so first, could you please put …" is also read as "put …".
//!
//! A sentence that is refused as it stands is read once more without words that change nothing, wherever they
//! stand, and with simpler phrases in place of others. The network judges what is left as if it had been said;
//! nothing is learned here: the model lists what is left out ([`crate::model::Simplification`]). The words say
//! nothing of objects, actions, or the order of steps, so that what is then understood is what was said.

use core::ops::Range;

use super::phrases::PhraseMatcher;
use super::words::word;
use super::{Token, TokenKind};

/// Marks that may be left over where the words between two of them are left out.
const MARKS: [&str; 5] = [",", ".", ":", "!", "?"];

impl<'a> PhraseMatcher<'_, 'a> {
    /// The longest phrase at a token that can be left out there or said in simpler words, and what is read in its place.
    pub(super) fn simpler(&self, tokens: &[Token], at: usize) -> Option<(Range<usize>, &'a str)> {
        let lists = self.model.simplification;
        let opening = || self.rephrased(&lists.opening, tokens, at);
        let closing = || self.rephrased(&lists.closing, tokens, at);
        let opening = (at == 0).then(opening).flatten();
        let anywhere = self.rephrased(&lists.anywhere, tokens, at);
        let closing = closing().filter(|(said, _)| said.end == tokens.len());
        let mut longest = opening;
        for found in [
            anywhere,
            closing,
            self.taken(tokens, at),
            self.standing(tokens, at),
        ]
        .into_iter()
        .flatten()
        {
            if longest
                .as_ref()
                .is_none_or(|(said, _)| said.end < found.0.end)
            {
                longest = Some(found);
            }
        }
        longest
    }

    /// What is read at a noun without attributes that stands somewhere: "thing standing" in place of "block" in "the block
    /// left of the red one".
    fn standing(&self, tokens: &[Token], at: usize) -> Option<(Range<usize>, &'a str)> {
        let standing = self.model.simplification.standing;
        let is_article = |token: &Token| self.is_one_of(self.model.ordinals.articles, token);
        tokens
            .get(at.checked_sub(1)?)
            .filter(|token| is_article(token))?;
        let noun = tokens.get(at)?;
        if !self.is_one_of(self.model.ordinals.nouns, noun) {
            return None;
        }
        let clause = tokens.get(at.checked_add(1)?..)?;
        let clause = self.longest::<&str>(clause, standing.clauses);
        let end = at
            .checked_add(1)?
            .checked_add(clause.map_or(0, |(length, _)| length))?;
        let relates = self.is_one_of(standing.relations, tokens.get(end)?);
        let is_read = self
            .begins_with(tokens.get(at..end)?, standing.read_as)
            .is_some();
        (relates && !is_read).then_some((at..end, standing.read_as))
    }

    /// How many of a step's first tokens only connect it to the step before: "and finally", "after that, listen:". None if
    /// it is said to be the first.
    pub(super) fn connecting(&self, step: &[Token]) -> usize {
        let connecting = &self.model.simplification.connecting;
        let mut behind = 0;
        while let Some((said, _)) = self.rephrased(connecting, step, behind) {
            behind = said.end;
        }
        let rest = step.get(behind..).unwrap_or_default();
        let mut opening = rest.iter().take_while(|token| !token.is_group());
        let starting = self.model.simplification.starting;
        if opening.any(|token| self.is_one_of(starting, token)) {
            return 0;
        }
        behind
    }

    /// What is read at a token that is about what is taken: "put" in place of "lift" in "lift the red block onto the
    /// blue one", and "it" in "take the red block and put on the blue one".
    fn taken(&self, tokens: &[Token], at: usize) -> Option<(Range<usize>, &'a str)> {
        let taking = self.model.simplification.taking;
        let is_taking = |token: &Token| self.is_one_of(taking.words, token);
        let described = |tokens: &[Token]| tokens.iter().filter(|token| token.is_group()).count();
        let (token, behind) = tokens.get(at..)?.split_first()?;
        if is_taking(token) {
            let towards = behind
                .iter()
                .position(|token| self.ends(token) || self.is_one_of(taking.towards, token))?;
            let is_moved = self.is_one_of(taking.towards, behind.get(towards)?)
                && described(behind.get(..towards)?) == 1;
            return is_moved.then(|| (at..at.saturating_add(1), taking.order));
        }
        let (last, said) = tokens.get(..at)?.split_last()?;
        let is_word = |token: &Token| matches!(token.kind, TokenKind::Word(_));
        let names_nothing = is_word(token)
            && !self.is_one_of(self.model.ordinals.articles, token)
            && !self
                .model
                .pronouns
                .iter()
                .any(|pronoun| token.kind == TokenKind::Word(pronoun.word));
        if !names_nothing || !self.puts(last) {
            return None;
        }
        let verb = said
            .iter()
            .rposition(|token| is_taking(token) || self.puts(token))?;
        let is_taken = said.get(verb).is_some_and(is_taking) && described(said.get(verb..)?) == 1;
        is_taken.then_some((at..at, taking.object))
    }

    /// The marks that are left over where words were left out before a token: one of two that they stood between, one at
    /// the beginning or at the end, and commas behind an article: "the, um, red block".
    pub(super) fn left_over(&self, tokens: &[Token], at: usize) -> Option<Range<usize>> {
        let behind = at.saturating_add(1);
        let (is_mark, ends) = (self.is_mark(tokens, at), at == tokens.len());
        let Some(before) = at.checked_sub(1) else {
            return is_mark.then_some(at..behind);
        };
        let is_comma = |index: usize| tokens.get(index).is_some_and(|token| self.is_comma(token));
        let is_article = |index: Option<usize>| {
            let token = index.and_then(|index| tokens.get(index));
            // "This, um, red block" has a pronoun in one reading.
            token.is_some_and(|token| {
                token.kind == TokenKind::Pronoun
                    || self.is_one_of(self.model.ordinals.articles, token)
            })
        };
        if !self.is_mark(tokens, before) {
            return (is_comma(at) && is_article(Some(before))).then_some(at..behind);
        }
        if ends || (is_comma(before) && is_mark && !is_comma(at)) {
            return Some(before..at);
        }
        let is_inside = is_comma(before) && is_comma(at) && is_article(before.checked_sub(1));
        let start = if is_inside { before } else { at };
        is_mark.then_some(start..behind)
    }

    /// The next noun from a token on behind which values stand that are its own: no noun follows them.
    pub(super) fn postposed(&self, tokens: &[Token], from: usize) -> Option<usize> {
        let is_noun = |index: usize| {
            let token = tokens.get(index);
            token.is_some_and(|token| self.is_one_of(self.model.ordinals.nouns, token))
        };
        let has_values = |index: usize| {
            let filters = tokens.get(index).and_then(Token::filters);
            filters.is_some_and(|filters| filters.choice().is_none())
        };
        (from..tokens.len()).find(|noun| {
            let values = noun.saturating_add(1);
            is_noun(*noun) && has_values(values) && !is_noun(values.saturating_add(1))
        })
    }

    /// Reads a pronoun before a description as the article that it is: "this, um, red block".
    pub(super) fn read_articles(&self, tokens: &mut [Token]) {
        for index in 1..tokens.len() {
            if let Some([article, described]) = tokens.get_mut(index.saturating_sub(1)..=index)
                && article.kind == TokenKind::Pronoun
                && described.filters().is_some()
                && let Some(word) = word(self.model, self.text(article))
            {
                article.kind = TokenKind::Word(word);
            }
        }
    }

    /// Whether a token is one of [`MARKS`].
    pub(super) fn is_mark(&self, tokens: &[Token], at: usize) -> bool {
        let token = tokens.get(at);
        token.is_some_and(|token| MARKS.iter().any(|mark| self.is(token, mark)))
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use crate::fixture::{self, parse};
    use crate::language::reader::Reading;
    use crate::language::{Reader, TokenKind};
    use crate::model::{
        Model, Ordinals, Pronoun, Rephrased, Rephrasing, Simplification, Standing, Taking,
    };

    const OPENING: [Rephrased<'static>; 2] = [
        Rephrased::new().with_text("so"),
        Rephrased::new().with_text("task 1"),
    ];
    const ANYWHERE: [Rephrased<'static>; 3] = [
        Rephrased::new().with_text("belongs").with_read_as("right"),
        Rephrased::new().with_text("task"),
        Rephrased::new().with_text("um"),
    ];
    const CLOSING: [Rephrased<'static>; 2] = [
        Rephrased::new().with_text("and that is it"),
        Rephrased::new().with_text("right"),
    ];

    fn model() -> Model<'static> {
        let mut model = fixture::with_compounds();
        model.simplification = Simplification::new()
            .with_opening(
                Rephrasing::new()
                    .with_said(&OPENING)
                    .with_first_words(&["so", "task"]),
            )
            .with_anywhere(
                Rephrasing::new()
                    .with_said(&ANYWHERE)
                    .with_first_words(&["belongs", "task", "um"]),
            )
            .with_closing(
                Rephrasing::new()
                    .with_said(&CLOSING)
                    .with_first_words(&["and", "right"]),
            );
        assert_eq!(model.check(), Ok(()));
        model
    }

    /// The words of a sentence as it is simplified.
    fn simplified(model: &Model<'_>, sentence: &str) -> String {
        let reading = Reading {
            number: 0,
            is_simplified: true,
        };
        let mut reader = Reader::nth(sentence, reading).unwrap();
        while reader.advance(model, sentence).is_ok_and(|goes_on| goes_on) {}
        let read = reader.tokens().iter().map(|token| match token.kind {
            TokenKind::Word(index) => model.words[usize::from(index)].text.into(),
            _ => token.span.of(sentence).unwrap().into(),
        });
        read.collect::<std::vec::Vec<String>>().join(" ")
    }

    #[test]
    fn what_changes_nothing_is_left_out_of_a_refused_sentence() {
        let model = model();
        let expected = parse(&model, "put red right green").unwrap();
        for sentence in [
            "um put um red um right green um",
            "so put red right green",
            "So, so, um: put red right green, um, and that is it.",
            "task 1 put red right green",
            "put red right the, um, green",
            "put red right the um, green",
            "put red, um, right green",
            "put red belongs green",
            "um put red belongs green right",
        ] {
            assert_eq!(
                parse(&model, sentence).as_ref(),
                Ok(&expected),
                "{sentence}"
            );
        }
    }

    #[test]
    fn what_only_connects_a_step_is_no_part_of_it() {
        let mut model = model();
        let said = ["near", "then"].map(|text| Rephrased::new().with_text(text));
        model.simplification.connecting = Rephrasing::new()
            .with_said(&said)
            .with_first_words(&["near", "then"]);
        model.simplification.starting = &["the"];
        assert_eq!(model.check(), Ok(()));
        let sentence = "put red right green then near near put lego on small";
        // As it stands, "near" makes the action unclear.
        assert!(parse(&model, sentence).is_err());
        let expected = parse(&model, "put red right green then put lego on small");
        assert!(expected.is_ok());
        assert_eq!(parse(&model, &std::format!("um {sentence}")), expected);
        // A further step is not said to be the first.
        let starts = "um put red right green then near the put lego on small";
        assert_eq!(parse(&model, starts).unwrap_err().kind(), "unknown_word");
        // Nothing connects the first one.
        let first = "um near put red right green";
        assert_eq!(parse(&model, first).unwrap_err().kind(), "unknown_word");
    }

    #[test]
    fn a_pronoun_before_a_description_is_an_article() {
        let mut model = model();
        let the = model.words.iter().position(|word| word.text == "the");
        let pronouns = [Pronoun {
            word: u16::try_from(the.unwrap()).unwrap(),
            owner: None,
        }];
        model.pronouns = &pronouns;
        model.ordinals = Ordinals::new().with_articles(&["the"]);
        assert_eq!(model.check(), Ok(()));
        let expected = parse(&model, "put red right green then put the lego on small");
        assert!(expected.is_ok());
        for the in ["the um", "the, um,", "the um,"] {
            let sentence = std::format!("put red right green then put {the} lego on small");
            assert_eq!(parse(&model, &sentence), expected, "{sentence}");
        }
    }

    #[test]
    fn an_object_that_stands_somewhere_alone_is_read_in_the_same_words() {
        let mut model = model();
        model.ordinals = Ordinals::new()
            .with_nouns(&["near"])
            .with_articles(&["the"]);
        model.simplification.standing = Standing::new()
            .with_clauses(&["that is", "that lies"])
            .with_relations(&["on", "right"])
            .with_read_as("near perhaps");
        assert_eq!(model.check(), Ok(()));
        for (sentence, read) in [
            (
                "put the near on red right green",
                "put the near perhaps on red right green",
            ),
            (
                "put the near that lies on red right green",
                "put the near perhaps on red right green",
            ),
            (
                "put red on the near that is right green",
                "put red on the near perhaps right green",
            ),
            // It has attributes, no article, or no relation.
            ("um put the red near on green", "put the red near on green"),
            (
                "um put near on red right green",
                "put near on red right green",
            ),
            (
                "um put the near red right green",
                "put the red near right green",
            ),
            // It is read so already.
            (
                "um put the near perhaps on red",
                "put the near perhaps on red",
            ),
        ] {
            assert_eq!(simplified(&model, sentence), read, "{sentence}");
        }
    }

    #[test]
    fn what_is_taken_is_not_named_again() {
        let mut model = model();
        let word = |text: &str| {
            let found = model.words.iter().position(|word| word.text == text);
            u16::try_from(found.unwrap()).unwrap()
        };
        let pronouns = [Pronoun {
            word: word("the"),
            owner: None,
        }];
        let placing = [word("put")];
        model.simplification.taking = Taking::new()
            .with_words(&["lift"])
            .with_towards(&["right"])
            .with_order("put")
            .with_object("the");
        model.pronouns = &pronouns;
        model.placing = &placing;
        assert_eq!(model.check(), Ok(()));
        let right = parse(&model, "put red right green");
        assert_eq!(parse(&model, "lift red right green"), right);
        // "Lift" is unknown to this model, but "the" is read.
        for (sentence, read) in [
            ("lift red put on green", "lift red put the on green"),
            ("lift red , put on green", "lift red , put the on green"),
            // It is named, or is another one.
            ("lift red put green on", "lift red put green on"),
            ("lift red put the on green", "lift red put the on green"),
            ("put red put on green", "put red put on green"),
            (
                "lift red on green put on red",
                "lift red on green put on red",
            ),
            ("lift red on green", "lift red on green"),
        ] {
            assert_eq!(simplified(&model, sentence), read);
        }
    }

    #[test]
    fn values_behind_a_noun_are_its_own() {
        let mut model = model();
        model.ordinals = Ordinals::new()
            .with_nouns(&["near"])
            .with_articles(&["the"]);
        assert_eq!(model.check(), Ok(()));
        for (sentence, same) in [
            (
                "um put the near red right green",
                "put the red near right green",
            ),
            (
                "um put the small near red right green",
                "put the small red near right green",
            ),
            (
                "um put the red near right green",
                "put the red near right green",
            ),
        ] {
            let expected = parse(&model, same);
            assert!(expected.is_ok(), "{same}: {expected:?}");
            assert_eq!(parse(&model, sentence), expected, "{sentence}");
        }
        for sentence in [
            "um put red near green right lego",
            "um put the near right near",
        ] {
            assert!(parse(&model, sentence).is_err(), "{sentence}");
        }
    }

    #[test]
    fn the_rest_must_make_sense() {
        let model = model();
        for (sentence, kind) in [
            ("um put red right huge", "unknown_word"),
            ("put red so right green", "unknown_word"),
            ("put red right green um and that is it so", "unknown_word"),
            ("um", "unknown_word"),
            ("um put red", "unknown_word"),
        ] {
            assert_eq!(
                parse(&model, sentence).unwrap_err().kind(),
                kind,
                "{sentence}"
            );
        }
    }

    #[test]
    fn a_sentence_that_makes_sense_is_read_as_it_stands() {
        let model = model();
        let said = "put red right green then put lego on right";
        assert_eq!(parse(&model, said), parse(&fixture::with_compounds(), said));
    }
}
