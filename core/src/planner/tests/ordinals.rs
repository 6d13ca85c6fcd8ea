//! "The second red from the right": which one is meant is counted.

use super::relations::{OTHER, lego, plan_with, red};
use super::*;
use crate::relation::CLEARLY_FARTHER_M;
use crate::scene::ObservedObject;

fn plan(objects: &[ObservedObject], sentence: &str) -> Result<Plan, Refusal> {
    plan_with(&fixture::with_ordinals(), objects, sentence)
}

/// The object to move of the only step.
fn moved(objects: &[ObservedObject], sentence: &str) -> u32 {
    relations::meant(&plan(objects, sentence).unwrap()).0
}

/// How many objects may be meant.
fn ambiguous(objects: &[ObservedObject], sentence: &str) -> usize {
    match plan(objects, sentence) {
        Err(Refusal::Ambiguous { candidates, .. }) => candidates.count(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn objects_that_fit_are_counted_from_the_extreme() {
    let objects = [red(1, 0.3, 0.8), red(2, 0.5, 0.5), red(3, 0.4, 0.2), lego()];
    for (sentence, expected) in [
        ("put the second red from right on lego", 3),
        ("put the third red from right on lego", 1),
        ("put the first red from right on lego", 2),
        ("put the second topmost red on lego", 2),
        // Whatever it is, the red one at the right is passed.
        ("put the second from right on lego", 3),
    ] {
        assert_eq!(moved(&objects, sentence), expected, "{sentence}");
    }
    let model = fixture::with_ordinals();
    let plan = plan_with(&model, &objects, "put the second red from right on lego").unwrap();
    assert!(plan.explain(&model).to_string().starts_with(
        "Step 1: move the second rightmost red object (id 3, score 1.00) on the lego object"
    ));
}

#[test]
fn there_must_be_as_many() {
    let objects = [red(1, 0.3, 0.8), red(2, 0.5, 0.5), lego()];
    let model = fixture::with_ordinals();
    let sentence = "put the third red from right on lego";
    let refused = plan(&objects, sentence).unwrap_err();
    assert!(
        matches!(refused, Refusal::NoSuchObject { .. }),
        "{refused:?}"
    );
    let message = refused.in_context(&model, sentence).to_string();
    assert!(
        message.contains("\"third rightmost red\" fits no object"),
        "{message}"
    );
}

#[test]
fn objects_that_are_hardly_apart_cannot_be_counted() {
    // The image is 0.5 m wide.
    let close = 0.5 - (CLEARLY_FARTHER_M - 0.001) / 0.5;
    let objects = [
        red(1, 0.9, 0.8),
        red(2, 0.5, 0.5),
        red(3, close, 0.2),
        red(4, 0.1, 0.5),
    ];
    let objects = [objects[0], objects[1], objects[2], objects[3], lego()];
    assert_eq!(
        ambiguous(&objects, "put the second red from right on lego"),
        2
    );
    assert_eq!(
        ambiguous(&objects, "put the third red from right on lego"),
        2
    );
    assert_eq!(moved(&objects, "put the first red from right on lego"), 1);
}

#[test]
fn what_may_fit_may_count() {
    // Something stands on object 3, which may be red; the image shows nothing that tells.
    let hidden = |x| {
        let mut on_top = fixture::object(4, OTHER, OTHER, x, 0.5);
        on_top.location[4] -= fixture::EDGE_M;
        let below = fixture::object(3, OTHER, OTHER, x, 0.5);
        [red(1, 0.7, 0.8), red(2, 0.45, 0.5), below, on_top, lego()]
    };
    let second = "put the second red from right on lego";
    assert_eq!(ambiguous(&hidden(0.86), second), 2);
    assert_eq!(ambiguous(&hidden(0.57), second), 2);
    // Behind both it does not matter.
    assert_eq!(moved(&hidden(0.2), second), 2);
    // Whether there is a third one, nobody knows.
    let sentence = "put the third red from right on lego";
    assert_eq!(ambiguous(&hidden(0.57), sentence), 1);
    let model = fixture::with_ordinals();
    let refused = plan(&hidden(0.57), sentence).unwrap_err();
    let message = refused.in_context(&model, sentence).to_string();
    assert_eq!(
        message,
        "step 1: the object \"third rightmost red\" may be object 2, but others hide a part of what may \
         count before it; uncover that, or describe the object in another way"
    );
}
