//! What is asked back after a refusal, and what answers lead to, with the model whose weights were
//! set by hand.

use nsrm::dialogue::Question;
use nsrm_core::Planner;
use nsrm_core::dsl::{Extreme, Property};
use nsrm_core::model::LexiconEntry;
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

/// What is asked where every action moves things to the right in the image, in which the blocks
/// stand in a row from left to right.
fn asked_in_a_row(blocks: &[Block], sentence: &str) -> Option<Question> {
    let mut parts = Parts::new();
    parts.simulator.output.bias[0] = 0.02;
    let model = parts.model();
    let scene = scene(&model, blocks);
    let refusal = Planner::new(&model)
        .plan(&scene, sentence)
        .expect_err(sentence);
    Question::after(&model, Some(&scene), &refusal, sentence)
}

const BEHIND: &str = "put the red block behind the blue block on the green block";

#[test]
fn an_answer_takes_the_place_of_words_and_relations() {
    let blocks = [
        block("lego", "blue"),
        block("small", "red"),
        block("lego", "red"),
        block("lego", "green"),
    ];
    let question = asked_in_a_row(&blocks, BEHIND).expect("two are red");
    assert_eq!(
        question.to_string(),
        "which \"red\" object: the lego red one or the small red one?"
    );
    let completed = question.complete("the small one");
    assert_eq!(
        completed.as_deref(),
        Some("put the small red block on the green block")
    );
}

#[test]
fn those_that_are_about_as_far_away_are_asked_about() {
    let sentence = "put the red block furthest the blue block on the green block";
    let blocks = [
        block("small", "red"),
        block("lego", "blue"),
        block("lego", "red"),
        block("lego", "green"),
    ];
    let question = asked_in_a_row(&blocks, sentence).expect("two are as far away");
    assert_eq!(
        question.to_string(),
        "which \"red\" object: the lego red one or the small red one?"
    );
    assert_eq!(
        question.complete("small").as_deref(),
        Some("put the small red block on the green block")
    );
}

#[test]
fn what_an_object_is_related_to_is_asked_about_in_its_own_place() {
    let blocks = [
        block("small", "blue"),
        block("lego", "blue"),
        block("small", "red"),
        block("lego", "green"),
    ];
    let question = asked_in_a_row(&blocks, BEHIND).expect("two are blue");
    assert_eq!(
        question.to_string(),
        "which \"blue\" object: the lego blue one or the small blue one?"
    );
    assert_eq!(
        question.complete("lego").as_deref(),
        Some("put the red block behind the lego blue block on the green block")
    );
    let chained = "put the red block behind the blue block behind the lego green block on the small \
                   green block";
    let blocks = [
        block("lego", "green"),
        block("small", "blue"),
        block("lego", "blue"),
        block("small", "red"),
        block("small", "green"),
    ];
    let question = asked_in_a_row(&blocks, chained).expect("two are blue");
    assert_eq!(
        question.complete("small").as_deref(),
        Some("put the red block behind the small blue block on the small green block")
    );
}

#[test]
fn what_has_no_words_of_its_own_is_not_asked_about() {
    let blocks = [
        block("lego", "blue"),
        block("small", "red"),
        block("lego", "green"),
    ];
    let sentence = "put opposite the blue block on the green block";
    assert_eq!(asked_in_a_row(&blocks, sentence), None);
    // But what it is related to is.
    let blocks = [
        block("lego", "green"),
        block("lego", "blue"),
        block("small", "blue"),
        block("small", "red"),
    ];
    let sentence = "put the green block on opposite the blue block";
    let question = asked_in_a_row(&blocks, sentence).expect("two are blue");
    assert_eq!(
        question.complete("small").as_deref(),
        Some("put the green block on opposite the small blue block")
    );
}

/// A model that knows "that is to the left of" and "to the right of".
fn sides() -> Parts {
    let mut parts = Parts::new();
    for (word, like) in [
        ("is", "block"),
        ("left", "behind"),
        ("of", "block"),
        ("right", "opposite"),
        ("that", "block"),
        ("to", "block"),
    ] {
        parts.add_word(word, like);
    }
    let unit = |text| {
        let embedding = parts.embeddings_of(text).encoder;
        let unit = embedding.iter().position(|value| *value != 0.0);
        unit.expect("it sets a unit")
    };
    let (left, right) = (unit("left"), unit("right"));
    // One forgets the other, as both do at "on" and "beside".
    for (word, other) in [(left, right), (right, left)] {
        let [_, update, _] = &mut parts.encoder.weight_ih[word];
        update[other] = -40.0;
    }
    let [on, beside] = &mut *parts.actions else {
        panic!("the model has two actions");
    };
    (on.phrase, beside.phrase) = ("to the right of", "to the left of");
    (on.simulator_bias[0], beside.simulator_bias[0]) = (20.0, -20.0);
    on.relation_decoder[0][right] = beside.relation_decoder[0][left];
    on.relation_bias[0] = beside.relation_bias[0];
    beside.relation_decoder[1] = on.relation_decoder[1];
    parts.simulate_one_unit();
    parts.simulator.output.weight[0][0] = 0.02;
    parts
}

/// As [`asked`], with a model that may know sides.
fn asked_by(parts: &Parts, blocks: &[Block], sentence: &str) -> Option<Question> {
    let model = parts.model();
    assert_eq!(model.check(), Ok(()));
    let scene = scene(&model, blocks);
    let refusal = Planner::new(&model)
        .plan(&scene, sentence)
        .expect_err(sentence);
    Question::after(&model, Some(&scene), &refusal, sentence)
}

const SMALL_RED: Block = block("small", "red");
const BLUE_BETWEEN: [Block; 4] = [
    SMALL_RED,
    block("lego", "blue"),
    SMALL_RED,
    block("lego", "green"),
];

/// The ids of the objects that a sentence moves among these blocks.
fn moved(parts: &Parts, blocks: &[Block], sentence: &str) -> Vec<u32> {
    let model = parts.model();
    let plan = Planner::new(&model).plan(&scene(&model, blocks), sentence);
    let plan = plan.expect(sentence);
    plan.sub_goals().map(|goal| goal.object).collect()
}

#[test]
fn what_looks_alike_is_told_apart_by_where_it_stands() {
    let parts = sides();
    let sentence = "put the red block on the green block";
    let question = asked_by(&parts, &BLUE_BETWEEN, sentence).expect("two are red");
    assert_eq!(
        question.to_string(),
        "which \"red\" object: the red one to the left of the lego blue one or the red one to the \
         right of the lego blue one?"
    );
    let left = "put the red that is to the left of the lego blue block on the green block";
    let right = "put the red that is to the right of the lego blue block on the green block";
    for (answer, completed) in [
        ("1", left),
        ("the left one", left),
        ("the one on the left", left),
        (
            "The red one that is to the left of the blue one, please.",
            left,
        ),
        ("the one which is on the right side", right),
        ("right of the lego blue block", right),
    ] {
        let got = question.complete(answer);
        assert_eq!(got.as_deref(), Some(completed), "{answer}");
    }
    for answer in [
        "the red one",
        "the blue one",
        "lego",
        "to",
        "on",
        "left right",
        "yes",
    ] {
        assert_eq!(question.complete(answer), None, "{answer}");
    }
    assert_eq!(moved(&parts, &BLUE_BETWEEN, left), [1]);
    assert_eq!(moved(&parts, &BLUE_BETWEEN, right), [3]);
}

#[test]
fn a_place_is_offered_for_references_and_inside_chains() {
    let parts = sides();
    let blocks = [
        block("lego", "green"),
        SMALL_RED,
        block("lego", "blue"),
        SMALL_RED,
    ];
    for (sentence, completed) in [
        (
            "put the green block on the red block",
            "put the green block on the red that is to the right of the lego blue block",
        ),
        (
            "put the green block to the left of the red block on the blue block",
            "put the green block to the left of the red that is to the right of the lego blue block \
             on the blue block",
        ),
    ] {
        let question = asked_by(&parts, &blocks, sentence).expect("two are red");
        let got = question.complete("right");
        assert_eq!(got.as_deref(), Some(completed));
        assert_eq!(moved(&parts, &blocks, completed), [1]);
    }
    // No room for another relation.
    let full = "put the green block to the left of the blue block to the left of the red block on \
                the blue block";
    assert_eq!(asked_by(&parts, &blocks, full), None);
}

#[test]
fn a_place_takes_that_of_a_refused_relation() {
    let parts = sides();
    let blocks = [
        SMALL_RED,
        block("lego", "blue"),
        SMALL_RED,
        block("lego", "green"),
    ];
    let sentence = "put the red block to the left of the green block on the blue block";
    let question = asked_by(&parts, &blocks, sentence).expect("two are red");
    assert_eq!(
        question.complete("left").as_deref(),
        Some("put the red that is to the left of the lego blue block on the blue block")
    );
}

#[test]
fn values_and_places_are_mixed() {
    let blocks = [
        block("lego", "red"),
        SMALL_RED,
        block("lego", "blue"),
        SMALL_RED,
    ];
    let question = asked_by(&sides(), &blocks, "put the red block on the blue block");
    let question = question.expect("three are red");
    // The lego red one and a small one are both to the left of the blue one.
    assert_eq!(
        question.to_string(),
        "which \"red\" object: the lego red one or the red one to the right of the lego blue one?"
    );
    assert_eq!(
        question.complete("the right one").as_deref(),
        Some("put the red that is to the right of the lego blue block on the blue block")
    );
    // Of the other option, this is only the anchor's word.
    for answer in ["the lego red one", "lego"] {
        let got = question.complete(answer);
        assert_eq!(
            got.as_deref(),
            Some("put the lego red block on the blue block")
        );
    }
}

#[test]
fn a_place_that_tells_nothing_apart_is_not_asked_about() {
    let parts = sides();
    let sentence = "put the red block on the green block";
    let (blue, green) = (block("lego", "blue"), block("lego", "green"));
    for blocks in [
        // Both are to the right of the blue and to the left of the green one.
        &[blue, SMALL_RED, SMALL_RED, green][..],
        // The anchor's values name two objects.
        &[SMALL_RED, blue, SMALL_RED, blue, green],
        // Only one of the three is told apart: to the left of the green one.
        &[SMALL_RED, green, SMALL_RED, SMALL_RED],
    ] {
        assert_eq!(asked_by(&parts, blocks, sentence), None, "{blocks:?}");
    }
}

#[test]
fn the_farthest_to_a_side_is_offered_where_no_relation_tells() {
    let mut parts = sides();
    parts.lexicon.retain(|entry| entry.text != "outermost");
    for (action, word) in [(0, "rightmost"), (1, "leftmost")] {
        parts.actions[action].extreme = Some(word);
        let property = Property::Extreme(Extreme::Action(action as u8));
        let entry = LexiconEntry::new().with_text(word);
        parts.lexicon.push(entry.with_property(property));
    }
    parts.lexicon.sort_by_key(|entry| entry.text);
    // The blue ones' values name two objects, and both red ones are to the left of the green one.
    let blue = block("lego", "blue");
    let blocks = [blue, SMALL_RED, blue, SMALL_RED, block("lego", "green")];
    let sentence = "put the red block on the green block";
    let question = asked_by(&parts, &blocks, sentence).expect("two are red");
    assert_eq!(
        question.to_string(),
        "which \"red\" object: the leftmost red one or the rightmost red one?"
    );
    for (answer, id) in [("the left one", 2), ("rightmost", 4), ("2", 4)] {
        let completed = question.complete(answer).expect(answer);
        assert_eq!(moved(&parts, &blocks, &completed), [id], "{completed}");
    }
    // Of three, the one in the middle is left to the person.
    let blocks = [
        SMALL_RED,
        blue,
        SMALL_RED,
        blue,
        SMALL_RED,
        block("lego", "green"),
    ];
    let question = asked_by(&parts, &blocks, sentence).expect("three are red");
    assert_eq!(question.options().len(), 2);
}

#[test]
fn where_objects_will_have_been_moved_is_not_asked_about() {
    let parts = sides();
    let anchor = "put the blue block on the green block then put the red block on the green block";
    assert_eq!(asked_by(&parts, &BLUE_BETWEEN, anchor), None);
    let other = "put the green block on the blue block then put the red block on the blue block";
    let question = asked_by(&parts, &BLUE_BETWEEN, other).expect("two are red");
    let completed = question.complete("left").expect("an option");
    assert_eq!(moved(&parts, &BLUE_BETWEEN, &completed), [4, 1]);
    // Without the first step, a small one is told apart by where it stands.
    let blocks = [
        SMALL_RED,
        block("lego", "blue"),
        block("lego", "red"),
        SMALL_RED,
        block("lego", "green"),
    ];
    let fitting = "put the red block on the blue block";
    assert!(asked_by(&parts, &blocks, fitting).is_some());
    let fitting = format!("put the lego red block on the green block then {fitting}");
    assert_eq!(asked_by(&parts, &blocks, &fitting), None);
}

#[test]
fn a_model_without_relations_asks_nothing_about_places() {
    let sentence = "put the red block on the green block";
    assert_eq!(asked_by(&Parts::new(), &BLUE_BETWEEN, sentence), None);
    // It knows the words, but not what they mean.
    let mut untaught = sides();
    for action in &mut untaught.actions {
        action.relation_decoder = [[0.0; _]; 2];
        action.relation_bias = [-20.0; 2];
    }
    assert_eq!(asked_by(&untaught, &BLUE_BETWEEN, sentence), None);
    // It was taught them, but not the words.
    let mut wordless = sides();
    wordless.remove_word("that");
    assert_eq!(asked_by(&wordless, &BLUE_BETWEEN, sentence), None);
}
