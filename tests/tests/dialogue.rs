//! What is asked back after a refusal, and what answers lead to, with the model whose weights were
//! set by hand.

use nsrm::dialogue::Question;
use nsrm_core::Planner;
use nsrm_tests::by_hand::{Block, Parts, block, scene};

/// What is asked about a sentence in the scene of these blocks.
fn asked(blocks: &[Block], sentence: &str) -> Option<Question> {
    let parts = Parts::new();
    let model = parts.model();
    let scene = scene(&model, blocks);
    let refusal = Planner::new(&model)
        .plan(&scene, sentence)
        .expect_err(sentence);
    Question::after(&model, Some(&scene), &refusal, sentence)
}

const BLOCKS: [Block; 4] = [
    block("small", "red"),
    block("lego", "red"),
    block("lego", "blue"),
    block("lego", "green"),
];

#[test]
fn which_of_several_objects_is_asked() {
    let sentence = "put the red block on the blue block";
    let question = asked(&BLOCKS, sentence).expect("two are red");
    assert_eq!(
        question.to_string(),
        "which \"red\" object: the lego red one or the small red one?"
    );
    let small = Some("put the small red block on the blue block".to_owned());
    for answer in [
        "the small one",
        "2",
        "Small.",
        "I mean the small red block, please",
    ] {
        assert_eq!(question.complete(answer), small, "{answer}");
    }
    let lego = Some("put the lego red block on the blue block".to_owned());
    assert_eq!(question.complete("lego"), lego);
    for answer in [
        "",
        "the red one",
        "yes",
        "0",
        "3",
        "blue",
        "small lego",
        "no",
    ] {
        assert_eq!(question.complete(answer), None, "{answer}");
    }
    // The place of the second argument, in a later step.
    let sentence =
        "put the blue block on the green block then put the green block on the red block";
    let question = asked(&BLOCKS, sentence).expect("two are red");
    let completed = question.complete("small").expect("one is small");
    assert!(completed.ends_with("put the green block on the small red block"));
}

#[test]
fn one_question_follows_another() {
    let blocks = [
        block("small", "red"),
        block("lego", "red"),
        block("lego", "blue"),
        block("small", "blue"),
    ];
    let first = asked(&blocks, "put the red block on the blue block").expect("two are red");
    let sentence = first.complete("the small one").expect("an option");
    let second = asked(&blocks, &sentence).expect("two are blue");
    assert!(second.to_string().starts_with("which \"blue\" object"));
    let sentence = second.complete("the lego one").expect("an option");
    assert_eq!(sentence, "put the small red block on the lego blue block");
}

#[test]
fn what_looks_alike_is_not_asked_about() {
    let blocks = [
        block("small", "red"),
        block("small", "red"),
        block("lego", "blue"),
    ];
    assert_eq!(asked(&blocks, "put the red block on the blue block"), None);
}

#[test]
fn what_is_most_alike_is_offered_for_what_is_not_there() {
    let question = asked(&BLOCKS, "put the small blue block on the green block").expect("others");
    assert_eq!(
        question.to_string(),
        "do you mean the lego blue one or the small red one?"
    );
    let completed = question.complete("the blue one").expect("an option");
    assert_eq!(completed, "put the lego blue block on the green block");
    // What the step would be put on itself is left out.
    let blocks = [block("small", "red"), block("lego", "blue")];
    let question = asked(&blocks, "put the green block on the blue block").expect("another");
    assert_eq!(question.to_string(), "do you mean the small red one?");
    let completed = question.complete("Yes!").expect("an option");
    assert_eq!(completed, "put the small red block on the blue block");
}

#[test]
fn the_rest_of_a_step_is_asked_for() {
    let question = asked(&BLOCKS, "put the small red block").expect("where to?");
    assert_eq!(
        question.to_string(),
        "\"put the small red block\" names one object only: what is missing?"
    );
    assert!(question.options().is_empty());
    let completed = question.complete("on the blue block.").expect("the rest");
    assert_eq!(completed, "put the small red block on the blue block");
    assert_eq!(question.complete(" "), None);
}

#[test]
fn a_known_word_is_offered_for_an_unknown_one() {
    // There is no small green one, which is the next question.
    let question = asked(&BLOCKS, "put the small gren block on the blue block").expect("green");
    let sentence = question.complete("yes").expect("an option");
    let question = asked(&BLOCKS, &sentence).expect("others");
    assert!(question.complete("the lego green one").is_some());
    let question = asked(&BLOCKS, "put the gren block on the blue block").expect("green");
    assert_eq!(question.to_string(), "do you mean \"green\"?");
    let completed = question.complete("yes").expect("an option");
    assert_eq!(completed, "put the green block on the blue block");
    assert_eq!(asked(&BLOCKS, "put the sofa on the blue block"), None);
    assert_eq!(
        asked(&BLOCKS, "put the red block sideways on the blue block"),
        None
    );
}
