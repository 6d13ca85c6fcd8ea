//! "All red ones", "both": several objects that are moved, one after the other.

use std::vec::Vec;

use super::relations::{plan, plan_with, red, refusal};
use super::*;
use crate::dsl::Quantifier;
use crate::model::{Arrangement, Arrangements, Closing, Model, Opening, Plural, Several};
use crate::scene::ObservedObject;

/// Ids of the object and the reference of each step.
fn moved(plan: &Plan) -> Vec<(u32, u32)> {
    let steps = plan.steps().iter();
    let pair = |step: &PlannedStep| (step.object.object, step.reference.object);
    steps.map(pair).collect()
}

/// Object 9, lego, at the lower left: there is room for a tower.
fn lego() -> ObservedObject {
    fixture::object(9, 2, fixture::LEGO, 0.1, 0.9)
}

/// Red ones, of which the second is the highest and the third the lowest.
fn three() -> [ObservedObject; 4] {
    let at = |id, height_m: f32| {
        let mut object = red(id, 0.2 * id as f32, 0.5);
        object.location[4] -= height_m;
        object
    };
    [at(1, 0.001), at(2, 0.002), at(3, 0.0), lego()]
}

#[test]
fn each_of_them_is_moved_the_highest_first_and_the_next_beside_the_one_before() {
    let model = fixture::related();
    let plan = plan(&three(), "put all red right lego").unwrap();
    assert_eq!(moved(&plan), [(2, 9), (1, 2), (3, 1)]);
    assert_eq!(
        plan.program().notation(&model).to_string(),
        "Action(MoveRight, Each(Filter(red, Scene())), Unique(Filter(lego, Scene())))\n\
         Action(MoveRight, Each(Filter(red, Scene())), Each(Filter(red, Scene())))\n\
         Action(MoveRight, Each(Filter(red, Scene())), Each(Filter(red, Scene())))"
    );
    let explained = plan.explain(&model).to_string();
    assert!(
        explained
            .starts_with("Step 1: move the red object (id 2, score 1.00) to the right of the lego"),
        "{explained}"
    );
    // Each stands beside the one before it, wherever that was before.
    let places: Vec<f32> = plan
        .sub_goals()
        .map(|goal| goal.pose.translation.y)
        .collect();
    assert!(places[0] > places[1] && places[1] > places[2], "{places:?}");
    // What was decided once counts once.
    let one = plan_with(&model, &three()[1..], "put rightmost red right lego").unwrap();
    let confidence = |plan: &Plan| plan.steps()[0].confidence;
    assert_eq!(confidence(&plan).action, confidence(&one).action);
    let later = plan.steps()[1].confidence;
    assert_eq!(
        [later.action, later.words, later.split, later.object],
        [1.0; 4]
    );
}

#[test]
fn what_they_are_moved_to_is_none_of_them() {
    let objects = three();
    let plan = plan(&objects, "put all on lego").unwrap();
    assert_eq!(moved(&plan), [(2, 9), (1, 2), (3, 1)]);
    let explained = plan.explain(&fixture::related()).to_string();
    assert!(
        explained.contains("Step 2: move the object (id 1"),
        "{explained}"
    );
    let one = plan_with(
        &fixture::related(),
        &objects,
        "put all red on rightmost red",
    )
    .unwrap();
    assert_eq!(moved(&one), [(2, 3), (1, 2)]);
}

#[test]
fn one_of_all_is_enough_and_both_are_two() {
    let objects = three();
    let one = plan(&objects[2..], "put all red on lego").unwrap();
    assert_eq!(moved(&one), [(3, 9)]);
    let two = plan(&objects[1..], "put both red on lego").unwrap();
    assert_eq!(moved(&two), [(2, 9), (3, 2)]);
    for (objects, got) in [(&objects[..], 3), (&objects[2..], 1)] {
        let (refused, message) = refusal(objects, "put both red on lego");
        assert!(matches!(refused, Refusal::OtherNumber { got: found, .. } if found == got));
        assert_eq!(
            message,
            std::format!(
                "step 1: the object \"both red\" means 2 objects, but fits {got}; describe them more \
                 closely"
            )
        );
    }
    let (refused, _) = refusal(&objects, "put all green on lego");
    assert!(matches!(refused, Refusal::NoSuchObject { .. }));
}

#[test]
fn they_may_be_described_by_where_they_are() {
    let green = fixture::object(4, fixture::GREEN, 2, 0.35, 0.5);
    let objects = [
        red(1, 0.2, 0.5),
        red(2, 0.5, 0.5),
        red(3, 0.7, 0.5),
        lego(),
        green,
    ];
    let found = plan(&objects, "put all red beside green on lego").unwrap();
    let mut ids: Vec<u32> = moved(&found).iter().map(|(id, _)| *id).collect();
    ids.sort_unstable();
    assert_eq!(ids, [2, 3]);
    // The second one is not clearly to the right of it.
    let objects = [objects[0], objects[1], red(3, 0.7, 0.8), lego(), green];
    let (refused, _) = refusal(&objects, "put all red beside green on lego");
    assert!(matches!(refused, Refusal::Ambiguous { .. }), "{refused:?}");
}

#[test]
fn what_is_hidden_in_part_may_be_one_of_them() {
    // Object 4 looks like nothing known, behind a nearer one.
    let mut front = fixture::object(5, 2, 2, 0.75, 0.85);
    front.location[4] -= 0.05;
    let hidden = fixture::object(4, 2, 2, 0.75, 0.8);
    let [one, two, _, lego] = three();
    let objects = [one, two, hidden, front, lego];
    let (refused, message) = refusal(&objects, "put all red on lego");
    assert!(
        matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 1),
        "{refused:?}"
    );
    assert!(
        message
            .starts_with("step 1: the object \"all red\" may or may not include object 4: others"),
        "{message}"
    );
    // Whatever it looks like, it is one of all.
    let all = plan(&[one, two, hidden, lego], "put all on lego").unwrap();
    assert_eq!(all.steps().len(), 3);
    assert!(plan(&[one, two, hidden, lego], "put all red on lego").is_ok());
}

#[test]
fn only_what_is_moved_may_be_several() {
    let sentence = "put lego on both red";
    let (refused, message) = refusal(&three(), sentence);
    assert!(matches!(
        refused,
        Refusal::SeveralReferences { step: 0, .. }
    ));
    assert_eq!(
        message,
        "step 1: \"both red\" describes several objects where a single one is needed; say which one"
    );
    for sentence in [
        "put all red closest green on lego",
        "put red beside all green on lego",
        "put lego on red beside all green",
    ] {
        assert_eq!(refusal(&three(), sentence).0.kind(), "several_references");
    }
    let (refused, message) = refusal(&three(), "put all rightmost red on lego");
    assert_eq!(refused.kind(), "conflicting_values");
    assert!(message.contains("both all and rightmost"), "{message}");
}

#[test]
fn a_program_has_no_more_steps_than_it_can_hold() {
    let many = |count: u32| -> Vec<ObservedObject> {
        let reds = (0..count).map(|id| red(id + 10, 0.2 + 0.07 * id as f32, 0.6));
        reds.chain([lego()]).collect()
    };
    let most = MAX_STEPS as u32;
    assert_eq!(
        plan(&many(most), "put all red on lego")
            .unwrap()
            .steps()
            .len(),
        MAX_STEPS
    );
    let (refused, message) = refusal(&many(most + 1), "put all red on lego");
    assert_eq!(
        refused,
        Refusal::TooManySteps {
            limit: MAX_STEPS as u8
        }
    );
    assert!(message.contains("one for each object"), "{message}");
    let twice = "put all red on lego then put all red right lego";
    assert_eq!(plan(&many(4), twice).unwrap().steps().len(), MAX_STEPS);
    assert_eq!(refusal(&many(5), twice).0.kind(), "too_many_steps");
}

#[test]
fn the_rest_is_about_the_same_objects() {
    let model = fixture::related();
    let planner = Planner::new(&model);
    let mut objects = three();
    let found = plan(
        &objects,
        "put all red right lego then put lego on rightmost red",
    )
    .unwrap();
    // Another red one has come, and one of the first has gone elsewhere.
    objects[0].location[0] += 0.1;
    objects[0].location[2] += 0.1;
    let objects = [
        objects[0],
        objects[1],
        objects[2],
        objects[3],
        red(4, 0.9, 0.1),
    ];
    let scene = Scene::new(fixture::raw_scene(&model, &objects), &model).unwrap();
    let mut task = planner.begin_grounding(&scene, found.parsed(), 1);
    let rest = loop {
        if let Poll::Ready(plan) = task.poll() {
            break plan.unwrap();
        }
    };
    assert_eq!(moved(rest)[..2], [(1, 2), (3, 1)]);
    assert_eq!(rest.program(), found.program());
    // One of them is gone.
    let scene = Scene::new(fixture::raw_scene(&model, &objects[1..]), &model).unwrap();
    let mut task = planner.begin_grounding(&scene, found.parsed(), 1);
    let refused = loop {
        if let Poll::Ready(plan) = task.poll() {
            break plan.unwrap_err();
        }
    };
    assert!(
        matches!(refused, Refusal::NoSuchObject { step: 1, .. }),
        "{refused:?}"
    );
}

#[test]
fn all_may_be_another_word_too() {
    let model = fixture::related();
    let mut lexicon = model.lexicon.to_vec();
    let all = lexicon
        .iter_mut()
        .find(|entry| entry.text == "all")
        .unwrap();
    all.text = "perhaps";
    lexicon.sort_by_key(|entry| entry.text);
    let model = model.with_lexicon(&lexicon);
    assert_eq!(model.check(), Ok(()));
    let planner = Planner::new(&model);
    let kinds = |sentence: &str| -> Vec<bool> {
        let parsed = planner.parse(sentence).unwrap();
        let steps = parsed.program().steps().iter();
        steps
            .map(|step| step.object.filters().quantifier().is_some())
            .collect()
    };
    assert_eq!(kinds("put perhaps red on lego"), [true]);
    assert_eq!(kinds("perhaps put red on lego"), [false]);
}

#[test]
fn words_are_in_the_plural_behind_a_quantifier_alone() {
    let model = fixture::related();
    let word = |text| {
        model
            .words
            .iter()
            .position(|word| word.text == text)
            .unwrap() as u16
    };
    let (between, plurals) = (
        [word("the")],
        [Plural::new().with_text("thens").with_word(word("the"))],
    );
    let several = Several::new().with_between(&between).with_plurals(&plurals);
    let several = Model { several, ..model };
    assert_eq!(several.check(), Ok(()));
    let parse = |model: &Model<'_>, sentence| {
        let parsed = Planner::new(model).parse(sentence);
        parsed.map(|parsed| parsed.program().clone())
    };
    let expected = parse(&several, "put all red the on lego");
    assert_eq!(
        expected.as_ref().unwrap().steps()[0]
            .object
            .filters()
            .quantifier(),
        Some(Quantifier::All)
    );
    for sentence in ["put all the red thens on lego", "put all red thens on lego"] {
        assert_eq!(parse(&several, sentence), expected, "{sentence}");
        assert_eq!(
            parse(&model, sentence).unwrap_err().kind(),
            "unknown_word",
            "{sentence}"
        );
    }
    for sentence in [
        "put red thens on lego",
        "put all red on green thens",
        "put thens on lego",
    ] {
        let refused = parse(&several, sentence).unwrap_err();
        assert_eq!(refused.kind(), "unknown_word", "{sentence}");
    }
}

/// [`fixture::related`], in which "the pile of" and "the row of" all red ones put them on and right of each other.
fn arranging() -> Model<'static> {
    const STEPS: [Arrangement<'static>; 2] = [
        Arrangement::new().with_order("put").with_relation("on"),
        Arrangement::new().with_order("put").with_relation("right"),
    ];
    const OPENINGS: [Opening<'static>; 2] = [
        Opening::new().with_text("the pile of").with_pattern(0),
        Opening::new().with_text("the row of").with_pattern(1),
    ];
    const CLOSINGS: [Closing<'static>; 2] = [
        Closing::new().with_pattern(0).with_arrangement(0),
        Closing::new().with_pattern(1).with_arrangement(1),
    ];
    let arrangements = Arrangements::new()
        .with_between(&["and"])
        .with_ends(&["then"])
        .with_next("then")
        .with_arrangements(&STEPS)
        .with_openings(&OPENINGS)
        .with_closings(&CLOSINGS);
    let model = fixture::related().with_arrangements(arrangements);
    assert_eq!(model.check(), Ok(()));
    model
}

#[test]
fn they_are_put_in_relation_to_each_other_and_the_lowest_one_stays() {
    let model = arranging();
    for (sentence, action) in [
        ("the pile of all red", "MoveOn"),
        ("the row of all red", "MoveRight"),
    ] {
        let parsed = Planner::new(&model).parse(sentence).unwrap();
        let notation = parsed.program().notation(&model).to_string();
        assert_eq!(
            notation,
            std::format!("Action({action}, All(Filter(red, Scene())), Itself())")
        );
        let plan = plan_with(&model, &three(), sentence).unwrap();
        assert_eq!(moved(&plan), [(2, 3), (1, 2)], "{sentence}");
        // The same from the second step on.
        let scene = Scene::new(fixture::raw_scene(&model, &three()), &model).unwrap();
        let mut task = Planner::new(&model).begin_grounding(&scene, plan.parsed(), 1);
        let rest = loop {
            if let Poll::Ready(rest) = task.poll() {
                break rest.unwrap();
            }
        };
        assert_eq!(moved(rest), [(1, 2)], "{sentence}");
    }
    let twice = plan_with(
        &model,
        &three(),
        "the row of all red then the pile of all red",
    )
    .unwrap();
    assert_eq!(moved(&twice), [(2, 3), (1, 2), (1, 3), (2, 1)]);
}

#[test]
fn one_alone_is_put_in_no_relation_to_itself() {
    let model = arranging();
    let one = [three()[0], lego()];
    let refused = plan_with(&model, &one, "the pile of all red").unwrap_err();
    let message = refused
        .in_context(&model, "the pile of all red")
        .to_string();
    assert_eq!(refused.kind(), "other_number");
    assert!(message.contains("means 2 objects, but fits 1"), "{message}");
    for sentence in [
        "the pile of red",
        "the pile of all red on lego",
        "put all red on lego right",
    ] {
        assert!(plan_with(&model, &three(), sentence).is_err(), "{sentence}");
    }
}
