//! "rightmost" and "topmost": which one of the objects that fit is meant.

use super::relations::{OTHER, lego, plan, plan_with, red, refusal};
use super::*;
use crate::model::Simulator;
use crate::relation::CLEARLY_FARTHER_M;
use crate::scene::ObservedObject;

/// The object to move and the reference of the only step.
fn meant(objects: &[ObservedObject], sentence: &str) -> (u32, u32) {
    relations::meant(&plan(objects, sentence).unwrap())
}

#[test]
fn of_the_objects_that_fit_the_farthest_in_the_actions_direction_is_meant() {
    let objects = [red(1, 0.3, 0.8), red(2, 0.5, 0.5), red(3, 0.4, 0.2), lego()];
    for (sentence, expected) in [
        ("put rightmost red on lego", (2, 9)),
        ("put red rightmost on lego", (2, 9)),
        ("put the rightmost on lego", (2, 9)),
        ("put lego on rightmost red", (9, 2)),
        // Along the image's height: what is higher in it.
        ("put topmost red on lego", (3, 9)),
        // Of those that are in the relation.
        ("put rightmost red above red rightmost on lego", (3, 9)),
    ] {
        assert_eq!(meant(&objects, sentence), expected, "{sentence}");
    }
    let model = fixture::related();
    let plan = plan_with(&model, &objects, "put rightmost red on lego").unwrap();
    assert!(plan.explain(&model).to_string().starts_with(
        "Step 1: move the rightmost red object (id 2, score 1.00) on the lego object"
    ));
}

#[test]
fn an_object_that_is_hardly_farther_makes_it_ambiguous() {
    // The image is 0.5 m wide.
    let apart = |distance_m: f32| {
        [
            red(1, 0.3, 0.3),
            red(2, 0.3 + distance_m / 0.5, 0.8),
            lego(),
        ]
    };
    let sentence = "put rightmost red on lego";
    assert_eq!(meant(&apart(CLEARLY_FARTHER_M + 0.001), sentence), (2, 9));
    let (refused, message) = refusal(&apart(CLEARLY_FARTHER_M - 0.001), sentence);
    assert!(matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 2));
    assert!(
        message.starts_with("step 1: the object \"rightmost red\" fits 2 objects: 1 (score 1.00)"),
        "{message}"
    );
}

#[test]
fn what_is_hidden_may_be_the_one_that_is_meant() {
    // Object 3 looks like nothing known, behind a nearer one, and is farther right than the red.
    let mut front = fixture::object(4, OTHER, OTHER, 0.75, 0.55);
    front.location[4] -= 0.05;
    let hidden = fixture::object(3, OTHER, OTHER, 0.75, 0.5);
    let objects = [red(1, 0.3, 0.5), red(2, 0.5, 0.5), hidden, front, lego()];
    let (refused, _) = refusal(&objects, "put rightmost red on lego");
    assert!(
        matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 2),
        "{refused:?}"
    );
    let seen = [objects[0], objects[1], objects[2], objects[4]];
    assert_eq!(meant(&seen, "put rightmost red on lego"), (2, 9));
}

#[test]
fn a_step_changes_who_is_the_farthest() {
    // Object 2 is moved onto object 1, so that object 3 is the rightmost then.
    let objects = [red(1, 0.3, 0.5), red(2, 0.8, 0.5), red(3, 0.6, 0.2), lego()];
    let model = fixture::related();
    let sentence = "put rightmost red on lego then put rightmost red on lego";
    let plan = plan_with(&model, &objects, sentence).unwrap();
    let moved: std::vec::Vec<u32> = plan.sub_goals().map(|goal| goal.object).collect();
    assert_eq!(moved, [2, 3]);
}

#[test]
fn nothing_that_fits_and_no_direction_are_refused() {
    let (refused, message) = refusal(&[red(1, 0.3, 0.5), lego()], "put rightmost green on lego");
    assert!(matches!(refused, Refusal::NoSuchObject { .. }));
    assert!(
        message.contains("\"rightmost green\" fits no object"),
        "{message}"
    );
    let model = fixture::related();
    let still = Simulator {
        output: fixture::linear(),
        ..*model.simulator
    };
    let model = model.with_simulator(&still);
    let objects = [red(1, 0.3, 0.5), lego()];
    let refused = plan_with(&model, &objects, "put rightmost red on lego").unwrap_err();
    assert!(matches!(refused, Refusal::NotFinite { .. }), "{refused:?}");
}

#[test]
fn the_largest_and_the_smallest_are_by_the_sizes_that_objects_show() {
    let object = |id, size, x| fixture::object(id, fixture::RED, size, x, 0.5);
    let mut concepts = [0, 1, 2, 3].map(|concept| fixture::related().concepts[concept]);
    concepts[3].edges_m = concepts[2]
        .edges_m
        .map(|edges| edges.map(|edge| 0.9 * edge));
    let model = fixture::related().with_concepts(&concepts);
    let (large, small) = (
        object(1, fixture::LEGO, 0.3),
        object(2, fixture::SMALL, 0.6),
    );
    let green = fixture::object(9, fixture::GREEN, fixture::SMALL, 0.1, 0.1);
    let moved = |objects: &[ObservedObject], sentence| {
        plan_with(&model, objects, sentence).map(|plan| plan.steps()[0].object.object)
    };
    let largest = "put largest red on green";
    let smallest = "put smallest red on green";
    let objects = [large, small, green];
    assert_eq!(moved(&objects, largest), Ok(1));
    assert_eq!(moved(&objects, smallest), Ok(2));
    let two = [large, small, object(3, fixture::LEGO, 0.9), green];
    assert!(matches!(
        moved(&two, largest),
        Err(Refusal::Ambiguous { .. })
    ));
    assert_eq!(moved(&two, smallest), Ok(2));
    // One that shows no size may be either.
    let unknown = [large, small, object(3, OTHER, 0.9), green];
    for sentence in [largest, smallest] {
        let refused = moved(&unknown, sentence).unwrap_err();
        assert!(
            matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 2)
        );
    }
    // A tenth smaller in each edge is 1.37 times as little in volume; a twentieth is no difference.
    concepts[3].edges_m = concepts[2]
        .edges_m
        .map(|edges| edges.map(|edge| 0.95 * edge));
    let model = fixture::related().with_concepts(&concepts);
    let refused = plan_with(&model, &objects, largest).unwrap_err();
    assert!(matches!(refused, Refusal::Ambiguous { .. }));
}

#[test]
fn what_is_seen_in_part_is_not_chosen() {
    // Something stands on object 3, the farthest to the right.
    let mut on_top = fixture::object(4, OTHER, OTHER, 0.75, 0.5);
    on_top.location[4] -= fixture::EDGE_M;
    let green = fixture::object(5, fixture::GREEN, OTHER, 0.2, 0.8);
    let objects = [red(1, 0.3, 0.5), red(3, 0.75, 0.5), on_top, lego(), green];
    let sentence = "put rightmost red on lego";
    let (refused, _) = refusal(&objects, sentence);
    assert!(matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 2));
    // If nothing else fits, the person is asked.
    let (refused, message) = refusal(&objects[1..], sentence);
    assert!(matches!(refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 1));
    assert_eq!(
        message,
        "step 1: the object \"rightmost red\" fits object 3 only, of which others hide a part; \
         uncover it, or describe another one"
    );
    // Without an extreme it is the only red one.
    let plan = plan_with(&fixture::related(), &objects[1..], "put red on lego").unwrap();
    assert_eq!(plan.steps()[0].object.object, 3);
    // Clearly behind another one, it does not matter.
    let objects = [red(1, 0.9, 0.5), red(3, 0.75, 0.5), on_top, lego()];
    assert_eq!(meant(&objects, sentence), (1, 9));
}

#[test]
fn what_an_earlier_step_uncovers_looks_as_it_did_before() {
    // Green stands on object 3, and is moved off it first.
    let mut on_top = fixture::object(4, fixture::GREEN, OTHER, 0.75, 0.5);
    on_top.location[4] -= fixture::EDGE_M;
    let objects = [red(1, 0.3, 0.5), red(3, 0.75, 0.5), on_top, lego()];
    let sentence = "put green on lego then put rightmost red on green";
    let (refused, _) = refusal(&objects, sentence);
    let Refusal::Ambiguous {
        step, candidates, ..
    } = refused
    else {
        panic!("{refused:?}");
    };
    assert_eq!((step, candidates.count()), (1, 2));
}
