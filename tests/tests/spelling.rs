//! Misspelt words are read as known ones if the sentence then makes sense, with the model whose
//! weights were set by hand.

use nsrm_core::language::word_hash;
use nsrm_core::model::{Heard, LexiconEntry, Model, Spelling};
use nsrm_core::{Planner, Refusal};
use nsrm_tests::by_hand::{Parts, block, scene};

const GOOD: &str = "put the red block on the blue block";

/// The corrections and the program's notation, or the word that is refused as unknown.
fn read(model: &Model<'_>, sentence: &str) -> Result<(Vec<String>, String), String> {
    match Planner::new(model).parse(sentence) {
        Ok(parsed) => {
            let corrections = parsed.corrections().iter();
            let told = corrections.map(|each| each.explain(model, sentence).to_string());
            Ok((told.collect(), parsed.program().notation(model).to_string()))
        }
        Err(Refusal::UnknownWord { span }) => Err(span
            .of(sentence)
            .expect("a word of the sentence")
            .to_owned()),
        Err(refusal) => panic!("{sentence:?}: {refusal:?}"),
    }
}

/// Of a model that takes no word for misspelt but those that `other_words` lack.
fn with_spelling(test: impl FnOnce(&Model<'_>)) {
    let parts = Parts::new();
    let mut other_words = ["reds", "then's", "bluer"].map(word_hash);
    other_words.sort_unstable();
    let heard = [Heard::new().with_text("read").with_read_as("red")];
    let spelling = Spelling::new()
        .with_heard(&heard)
        .with_other_words(&other_words);
    let model = parts.model().with_spelling(spelling);
    assert_eq!(model.check(), Ok(()));
    test(&model);
}

#[test]
fn a_misspelt_word_is_read_as_the_known_one_nearby_and_that_is_told() {
    with_spelling(|model| {
        let (_, program) = read(model, GOOD).expect("a good sentence");
        for (sentence, told) in [
            (GOOD, &[][..]),
            (
                "put teh red block on the bleu blokc",
                &[
                    "\"teh\" was read as \"the\"",
                    "\"bleu\" was read as \"blue\"",
                    "\"blokc\" was read as \"block\"",
                ],
            ),
            (
                "Put the READ block on the bblue block.",
                &[
                    "\"READ\" was read as \"red\"",
                    "\"bblue\" was read as \"blue\"",
                ],
            ),
            // Read as "then", which may stand there no more than "the" may be left out.
            (
                "put the red block on thn blue block",
                &["\"thn\" was read as \"the\""],
            ),
        ] {
            let (corrections, understood) = read(model, sentence).expect(sentence);
            assert_eq!(corrections, told, "{sentence}");
            assert_eq!(understood, program, "{sentence}");
        }
        let scene = scene(model, &[block("small", "red"), block("lego", "blue")]);
        let sentence = "put the rde block on the blue block";
        let plan = Planner::new(model).plan(&scene, sentence).expect("a plan");
        let told = plan.corrections()[0].explain(model, sentence).to_string();
        assert_eq!(told, "\"rde\" was read as \"red\"");
    });
}

#[test]
fn a_word_that_may_be_another_one_is_refused() {
    with_spelling(|model| {
        for (sentence, unknown) in [
            // In the dictionary.
            ("put the reds block on the blue block", "reds"),
            ("put the red block on the bluer block", "bluer"),
            // Two edits away, too short, or not only letters.
            ("put the rrdd block on the blue block", "rrdd"),
            ("put the red block onn blue", "onn"),
            ("put the re block on the blue block", "re"),
            ("put the red1 block on the blue block", "red1"),
            // The sentence makes no sense with it, or with any other word of the same sentence.
            ("put sideway the red block on the blue block", "sideway"),
            ("put teh red block on sideway the blue block", "teh"),
            // A further word is unknown.
            ("put teh red block on the purple block", "purple"),
            // More misspelt words than are read as others.
            ("put thn red block on thn thn thn thn blue block", "thn"),
        ] {
            assert_eq!(read(model, sentence), Err(unknown.into()), "{sentence}");
        }
        let nothing = model.with_spelling(Spelling::new());
        let sentence = "put teh red block on the blue block";
        assert_eq!(read(&nothing, sentence), Err("teh".into()));
    });
}

#[test]
fn a_word_that_may_stand_for_two_with_different_meanings_is_refused() {
    with_spelling(|model| {
        let mut lexicon = model.lexicon.to_vec();
        // Blue, as one letter in "rad" may make it.
        lexicon.push(LexiconEntry::new().with_text("rod").with_concept(2));
        lexicon.sort_by_key(|entry| entry.text);
        let model = model.with_lexicon(&lexicon);
        assert_eq!(model.check(), Ok(()));
        let sentence = "put the rad block on the green block";
        assert_eq!(read(&model, sentence), Err("rad".into()));
        let (told, _) = read(&model, "put the rdo block on the green block").expect("blue");
        assert_eq!(told, ["\"rdo\" was read as \"rod\""]);
    });
}
