//! Descriptions by relations, with the fixture that knows them: `beside` is to the right of, `above`
//! on, and `past` stands for what is to the right of something; `closest` and `furthest` compare, and
//! `around` stands for what is nearest to something.

use std::format;
use std::vec::Vec;

use super::*;
use crate::language::Span;
use crate::relation::{CLEARLY_NEARER, RELATION_CLEAR};
use crate::scene::ObservedObject;

/// Neither of the fixture's colours, and neither of its sizes.
pub(super) const OTHER: usize = 2;
const RED: usize = fixture::RED;
const GREEN: usize = fixture::GREEN;

/// Object 1, small and green, in the middle of the image.
fn green() -> ObservedObject {
    fixture::object(1, GREEN, OTHER, 0.5, 0.5)
}

/// Object 9, lego, out of the way: left of the middle and above it.
pub(super) fn lego() -> ObservedObject {
    fixture::object(9, OTHER, fixture::LEGO, 0.1, 0.1)
}

pub(super) fn red(id: u32, x: f32, y: f32) -> ObservedObject {
    fixture::object(id, RED, OTHER, x, y)
}

pub(super) fn plan_with(
    model: &Model<'_>,
    objects: &[ObservedObject],
    sentence: &str,
) -> Result<Plan, Refusal> {
    let scene = Scene::new(fixture::raw_scene(model, objects), model).unwrap();
    Planner::new(model).plan(&scene, sentence)
}

pub(super) fn plan(objects: &[ObservedObject], sentence: &str) -> Result<Plan, Refusal> {
    plan_with(&fixture::related(), objects, sentence)
}

/// The refusal, and how a person reads it.
pub(super) fn refusal(objects: &[ObservedObject], sentence: &str) -> (Refusal, String) {
    let model = fixture::related();
    let refusal = plan(objects, sentence).unwrap_err();
    let message = refusal.in_context(&model, sentence).to_string();
    (refusal, message)
}

/// Ids of the objects of the only step.
pub(super) fn meant(plan: &Plan) -> (u32, u32) {
    let [step] = plan.steps() else {
        panic!("{plan:?}");
    };
    (step.object.object, step.reference.object)
}

const SENTENCE: &str = "put the red beside green on the lego";

#[test]
fn an_object_is_found_by_where_it_lies() {
    let model = fixture::related();
    let objects = [green(), red(2, 0.75, 0.5), red(3, 0.25, 0.5), lego()];
    let plan = plan(&objects, SENTENCE).unwrap();
    assert_eq!(meant(&plan), (2, 9));
    assert_eq!(
        plan.program().notation(&model).to_string(),
        "Action(MoveOn, Unique(Filter(red, Relate(MoveRight, Unique(Filter(green, Scene()))))), \
         Unique(Filter(lego, Scene())))"
    );
    let step = plan.steps()[0];
    assert_eq!(
        (step.object.anchors(), step.reference.anchors()),
        (&[1][..], &[][..])
    );
    assert!((step.object.score - 1.0).abs() < 1e-5);
    assert!((step.confidence.relations - 1.0).abs() < 1e-5);
    // Both choices of the chain: the other three have a cosine of 0 to green; to red beside green
    // they have −1, and lego that of 135°.
    let of_green = 1.0 / (1.0 + 3.0 * libm::expf(-10.0));
    let of_red = 1.0 / (1.0 + 2.0 * libm::expf(-20.0) + libm::expf(-17.071));
    assert!((step.object.probability - of_green * of_red).abs() < 1e-6);
    assert_eq!(
        plan.explain(&model).to_string(),
        "Step 1: move the red object that is to the right of the green object (id 2, score 1.00) \
         on the lego object (id 9, score 1.00); confidence 1.00."
    );
    let parsed = Planner::new(&model).parse(SENTENCE).unwrap();
    let decisions = parsed.decisions()[0];
    assert_eq!(decisions.object_span.of(SENTENCE), Some("red beside green"));
    assert_eq!(decisions.reference_span.of(SENTENCE), Some("lego"));
    assert!((decisions.relations - 1.0).abs() < 1e-5);
}

#[test]
fn the_reference_may_have_a_relation_too() {
    let objects = [green(), red(2, 0.75, 0.5), red(3, 0.25, 0.5), lego()];
    let plan = plan(&objects, "put lego on red beside green").unwrap();
    assert_eq!(meant(&plan), (9, 2));
}

#[test]
fn what_is_only_vaguely_in_the_relation_is_refused() {
    let objects = [green(), red(2, 0.75, 0.75), lego()];
    let (refused, message) = refusal(&objects, SENTENCE);
    let Refusal::NoSuchObject {
        argument: Argument::Object,
        best: Some(Candidate { object: 2, score }),
        threshold: RELATION_CLEAR,
        ..
    } = refused
    else {
        panic!("{refused:?}");
    };
    assert!((score - core::f32::consts::FRAC_1_SQRT_2).abs() < 1e-5);
    assert_eq!(
        message,
        "step 1: the object \"red to the right of green\" fits no object in the scene: the best \
         is object 2 with a score of 0.71, needed 0.77"
    );
}

#[test]
fn a_doubtful_rival_makes_it_ambiguous() {
    let objects = [green(), red(2, 0.75, 0.5), red(3, 0.75, 0.75), lego()];
    let (refused, message) = refusal(&objects, SENTENCE);
    assert!(matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 2));
    assert!(
        message.starts_with(
            "step 1: the object \"red to the right of green\" fits 2 objects: 2 (score 1.00), 3"
        ),
        "{message}"
    );
}

#[test]
fn an_object_without_values_is_what_lies_there() {
    let model = fixture::related();
    let objects = [green(), fixture::object(2, OTHER, OTHER, 0.75, 0.5), lego()];
    let sentence = "put past green on lego";
    let plan = plan(&objects, sentence).unwrap();
    assert_eq!(meant(&plan), (2, 9));
    assert!(plan.explain(&model).to_string().starts_with(
        "Step 1: move the object that is to the right of the green object (id 2, score 1.00)"
    ));
    // It is not green itself, nor is anything where nothing lies.
    let (refused, message) = refusal(&[green(), lego()], sentence);
    assert!(matches!(refused, Refusal::NoSuchObject { .. }));
    assert!(
        message.starts_with("step 1: the object \"what is to the right of green\" fits no object"),
        "{message}"
    );
}

/// Lego, above it a green object with a red one to its right, and a green one elsewhere.
fn chained(other_green: (f32, f32)) -> [ObservedObject; 5] {
    [
        fixture::object(1, GREEN, OTHER, 0.5, 0.5),
        fixture::object(2, GREEN, OTHER, other_green.0, other_green.1),
        red(3, 0.75, 0.5),
        fixture::object(4, OTHER, fixture::LEGO, 0.5, 0.75),
        fixture::object(5, OTHER, fixture::SMALL, 0.1, 0.9),
    ]
}

#[test]
fn an_anchor_may_have_an_anchor() {
    let model = fixture::related();
    let scene = fixture::raw_scene(&model, &chained((0.2, 0.75)));
    let scene = Scene::new(scene, &model).unwrap();
    let sentence = "put red beside green above lego on small";
    let mut task = Planner::new(&model).begin(&scene, sentence);
    let mut polls = 1;
    let plan = loop {
        match task.poll() {
            Poll::Pending => polls += 1,
            Poll::Ready(plan) => break plan.unwrap(),
        }
    };
    assert_eq!(meant(plan), (3, 5));
    assert_eq!(plan.steps()[0].object.anchors(), [1, 4]);
    // 8 words and the end read, 8 tokens split, 16 encoded, the end of the parser, the check of the
    // scene, the step's begin, three decoders, four groups' roles, 4·(5 scores and a choice) and
    // the action.
    assert_eq!(polls, 9 + 8 + 16 + 1 + 1 + 1 + 3 + 4 + 4 * 6 + 1);
}

#[test]
fn a_refused_anchor_is_named_by_its_own_description() {
    let sentence = "put red beside green above lego on small";
    let (refused, message) = refusal(&chained((0.4, 0.4)), sentence);
    let Refusal::Ambiguous {
        argument: Argument::Object,
        description,
        candidates,
        ..
    } = refused
    else {
        panic!("{refused:?}");
    };
    assert_eq!((description.relations().len(), candidates.count()), (1, 2));
    assert!(message.starts_with("step 1: the object \"green on lego\" fits 2 objects"));
    let no_lego = chained((0.2, 0.75)).map(|object| match object.id {
        4 => fixture::object(4, OTHER, OTHER, 0.5, 0.75),
        _ => object,
    });
    let (_, message) = refusal(&no_lego, sentence);
    assert!(message.starts_with("step 1: the object \"lego\" fits no object"));
}

#[test]
fn later_steps_relate_to_where_earlier_ones_have_moved_things() {
    let objects = [
        fixture::object(1, GREEN, OTHER, 0.3, 0.85),
        // To the right of where green is.
        red(2, 0.45, 0.85),
        // To the right of where it will be: (0.375, 0.25).
        red(3, 0.625, 0.25),
        fixture::object(4, OTHER, fixture::LEGO, 0.25, 0.25),
        fixture::object(5, OTHER, fixture::SMALL, 0.9, 0.6),
    ];
    let alone = plan(&objects, "put red beside green on small").unwrap();
    assert_eq!(meant(&alone), (2, 5));
    let both = plan(
        &objects,
        "put green right lego then put red beside green on small",
    );
    assert_eq!(both.unwrap().steps()[1].object.object, 3);
}

#[test]
fn relations_make_no_third_object_and_replace_none() {
    let objects = [green(), red(2, 0.75, 0.5), lego()];
    let (refused, message) = refusal(&objects, "put red beside green");
    assert!(matches!(
        refused,
        Refusal::IncompleteStep {
            references: 1,
            span: Span { start: 0, end: 20 },
            ..
        }
    ));
    assert!(message.contains("describes 1 of the two objects"));
    let sentence = "put red beside green on lego the small";
    let (refused, message) = refusal(&objects, sentence);
    assert!(matches!(
        refused,
        Refusal::TooManyReferences { limit: 2, .. }
    ));
    assert!(message.contains("describes more than 2 objects"));
    // More groups than two descriptions can have.
    let sentence = String::from("put red") + &" beside green".repeat(MAX_GROUPS);
    let (refused, _) = refusal(&objects, &sentence);
    assert!(matches!(
        refused,
        Refusal::TooManyReferences { limit: 6, .. }
    ));
}

#[test]
fn a_chain_that_is_too_long_is_refused() {
    let sentence = "put red beside green beside green beside green on lego";
    let (refused, message) = refusal(&[green(), lego()], sentence);
    let span = Span { start: 4, end: 46 };
    assert_eq!(
        refused,
        Refusal::TooManyRelations {
            step: 0,
            span,
            limit: 2
        }
    );
    assert_eq!(
        message,
        "step 1: \"red beside green beside green beside green\" describes one object by more than \
         2 others; describe it by fewer"
    );
}

#[test]
fn a_relation_that_is_not_sure_is_refused() {
    let (refused, message) = refusal(&[green(), lego()], "put red roughly green on lego");
    assert!(matches!(
        refused,
        Refusal::Unsure {
            decision: Decision::Relation,
            ..
        }
    ));
    assert!(
        message.starts_with("step 1: not sure how the described objects are related"),
        "{message}"
    );
    // Nothing is described before the first group.
    let plan = plan(&[red(2, 0.75, 0.5), lego()], "put beside red on lego").unwrap();
    assert_eq!(meant(&plan), (2, 9));
}

#[test]
fn relations_that_are_not_finite_are_refused() {
    let model = fixture::related();
    let objects = [green(), red(2, 0.75, 0.5), lego()];
    let quantity = |model: &Model<'_>| match plan_with(model, &objects, SENTENCE) {
        Err(Refusal::NotFinite { step: 0, quantity }) => quantity,
        other => panic!("{other:?}"),
    };
    let mut actions = [model.actions[0], model.actions[1]];
    actions[0].relation_bias[1] = f32::NAN;
    let broken = Model {
        actions: &actions,
        ..model
    };
    assert_eq!(quantity(&broken), Quantity::Relation);
    let mut simulator = *model.simulator;
    simulator.output.bias[4] = f32::INFINITY;
    let broken = Model {
        simulator: &simulator,
        ..model
    };
    assert_eq!(quantity(&broken), Quantity::Score(Argument::Object));
}

/// Green in the middle, and red objects at these distances to its right, in half metres.
fn at_distances(distances: &[f32]) -> Vec<ObservedObject> {
    let mut objects = std::vec![green(), lego()];
    for (id, distance) in (2..).zip(distances) {
        objects.push(red(id, 0.5 + distance, 0.5));
    }
    objects
}

#[test]
fn superlatives_compare_those_that_fit() {
    let model = fixture::related();
    // Lego is nearer than all of them, and does not fit.
    let mut objects = at_distances(&[0.3, 0.2, 0.4]);
    objects[1] = fixture::object(9, OTHER, fixture::LEGO, 0.5, 0.4);
    for (word, expected, name, said) in [
        ("closest", 3, "Nearest", "nearest to"),
        ("furthest", 4, "Farthest", "farthest from"),
    ] {
        let plan = plan(&objects, &format!("put the red {word} green on lego")).unwrap();
        assert_eq!(meant(&plan), (expected, 9), "{word}");
        assert_eq!(plan.steps()[0].object.anchors(), [1]);
        assert_eq!(
            plan.program().notation(&model).to_string(),
            format!(
                "Action(MoveOn, Unique(Filter(red, Relate({name}, Unique(Filter(green, \
                 Scene()))))), Unique(Filter(lego, Scene())))"
            )
        );
        let explained = plan.explain(&model).to_string();
        let start = format!("Step 1: move the red object that is {said} the green object (id ");
        assert!(explained.starts_with(&start), "{explained}");
    }
    // Without values it compares all.
    let around = plan(&objects, "put around green on red closest green").unwrap();
    assert_eq!(meant(&around), (9, 3));
}

#[test]
fn what_is_not_clearly_the_nearest_is_refused() {
    for (word, distances, expected) in [
        ("closest", [0.2, 0.2 * CLEARLY_NEARER + 1e-4], true),
        ("closest", [0.2, 0.2 * CLEARLY_NEARER - 1e-4], false),
        ("furthest", [0.2, 0.2 * CLEARLY_NEARER + 1e-4], true),
        ("furthest", [0.2, 0.2 * CLEARLY_NEARER - 1e-4], false),
    ] {
        let objects = at_distances(&distances);
        let planned = plan(&objects, &format!("put the red {word} green on lego"));
        let found = planned.as_ref().map(meant);
        if expected {
            let moved = if word == "closest" { 2 } else { 3 };
            assert_eq!(found, Ok((moved, 9)), "{word} {distances:?}");
        } else {
            let Err(Refusal::Ambiguous { candidates, .. }) = found else {
                panic!("{word} {distances:?}: {found:?}");
            };
            let ids: Vec<u32> = candidates.listed().iter().map(|each| each.object).collect();
            assert_eq!(ids, [2, 3]);
        }
    }
    let (_, message) = refusal(&at_distances(&[0.2, 0.21]), "put red closest green on lego");
    assert!(
        message.starts_with(
            "step 1: the object \"red nearest to green\" fits 2 objects: 2 (score 1.00), 3"
        ),
        "{message}"
    );
}

#[test]
fn what_is_hidden_may_be_meant() {
    let sentence = "put red closest green on small";
    let small = fixture::object(8, OTHER, fixture::SMALL, 0.1, 0.9);
    let mut objects = at_distances(&[0.3]);
    objects.extend([small, fixture::object(5, OTHER, OTHER, 0.65, 0.5)]);
    assert_eq!(meant(&plan(&objects, sentence).unwrap()), (2, 8));
    // Something stands on it: what it looks like is not seen.
    let mut over = fixture::object(6, OTHER, fixture::SMALL, 0.65, 0.5);
    over.location[4] -= fixture::EDGE_M;
    objects.push(over);
    objects.retain(|object| object.id != 8);
    let (refused, _) = refusal(&objects, sentence);
    let Refusal::Ambiguous { candidates, .. } = refused else {
        panic!("{refused:?}");
    };
    let found: Vec<_> = candidates
        .listed()
        .iter()
        .map(|each| (each.object, each.score))
        .collect();
    let threshold = fixture::related().header.thresholds.match_score;
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].0, found[1]), (2, (5, threshold)));
    // Not if it is clearly farther away, nor if nothing else fits.
    objects[2] = red(2, 0.42, 0.5);
    assert_eq!(meant(&plan(&objects, sentence).unwrap()), (2, 6));
    objects.remove(2);
    let (refused, _) = refusal(&objects, sentence);
    assert!(
        matches!(refused, Refusal::NoSuchObject { .. }),
        "{refused:?}"
    );
}

#[test]
fn a_superlative_needs_one_anchor_and_something_that_fits() {
    // The only red one is the nearest and the farthest.
    let objects = at_distances(&[0.3]);
    for word in ["closest", "furthest"] {
        let plan = plan(&objects, &format!("put red {word} green on lego")).unwrap();
        assert_eq!(meant(&plan), (2, 9));
    }
    // An object is not the nearest to itself.
    let (refused, message) = refusal(&at_distances(&[]), "put green closest green on lego");
    assert!(
        matches!(refused, Refusal::NoSuchObject { .. }),
        "{refused:?}"
    );
    assert!(
        message.starts_with("step 1: the object \"green nearest to green\" fits no object"),
        "{message}"
    );
    let (refused, message) = refusal(&at_distances(&[0.2, 0.4]), "put lego on green closest red");
    assert!(matches!(refused, Refusal::Ambiguous { .. }));
    assert!(message.contains("\"red\" fits 2 objects"), "{message}");
}

#[test]
fn what_an_earlier_step_moves_is_compared_where_it_will_be() {
    let objects = at_distances(&[0.15, 0.25]);
    // To the right of red beside it, at 0.375.
    let sentence = "put red closest green right red furthest green then put red closest green on \
                    lego";
    let plan = plan(&objects, sentence).unwrap();
    let moved: Vec<u32> = plan.steps().iter().map(|step| step.object.object).collect();
    assert_eq!(moved, [2, 3]);
}

#[test]
fn distances_that_are_not_finite_are_refused() {
    let model = fixture::related();
    let mut camera = *model.camera;
    camera.weight[0][5] = f32::INFINITY;
    let broken = Model {
        camera: &camera,
        ..model
    };
    let refused = plan_with(
        &broken,
        &at_distances(&[0.2]),
        "put red closest green on lego",
    );
    assert!(refused.is_err());
}

#[test]
fn what_the_anchor_is_described_by_may_be_meant_itself() {
    let objects = [
        green(),
        fixture::object(9, OTHER, fixture::LEGO, 0.3, 0.5),
        red(2, 0.8, 0.8),
    ];
    for sentence in [
        "put lego closest green beside lego right red",
        "put red right lego closest green beside lego",
    ] {
        let plan = plan(&objects, sentence).unwrap_or_else(|refusal| panic!("{refusal:?}"));
        let (object, reference) = meant(&plan);
        assert!([object, reference].contains(&9), "{sentence}");
    }
}
