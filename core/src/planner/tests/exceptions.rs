//! What is left out of a description, "all small ones except the red one".

use std::vec::Vec;

use super::relations::{lego, plan_with};
use super::*;
use crate::scene::ObservedObject;

const SMALL: usize = fixture::SMALL;

/// A small red one, a small green one, and a further small one to the right.
fn objects(color: usize) -> [ObservedObject; 4] {
    [
        fixture::object(1, fixture::RED, SMALL, 0.3, 0.5),
        fixture::object(2, fixture::GREEN, SMALL, 0.5, 0.5),
        fixture::object(3, color, SMALL, 0.7, 0.5),
        lego(),
    ]
}

/// Ids of the objects that are moved.
fn moved(color: usize, sentence: &str) -> Result<Vec<u32>, Refusal> {
    let plan = plan_with(&fixture::with_exceptions(), &objects(color), sentence)?;
    Ok(plan.steps().iter().map(|step| step.object.object).collect())
}

#[test]
fn what_is_left_out_is_not_moved() {
    for (sentence, expected) in [
        ("put all small except the red on lego", &[2, 3][..]),
        ("put all small except all red on lego", &[2, 3]),
        ("put all small near that isn't red on lego", &[2, 3]),
        ("put all small except green on lego", &[1]),
        (
            "put the rightmost small near that isn't green on lego",
            &[1],
        ),
    ] {
        assert_eq!(
            moved(fixture::GREEN, sentence).unwrap(),
            expected,
            "{sentence}"
        );
    }
    let one = "put the small near that isn't green on lego";
    assert_eq!(moved(fixture::GREEN, one).unwrap(), [1]);
    let plan = plan_with(&fixture::with_exceptions(), &objects(fixture::GREEN), one).unwrap();
    let told = plan.explain(&fixture::with_exceptions()).to_string();
    assert!(
        told.contains("move the small object except green (id 1"),
        "{told}"
    );
}

#[test]
fn what_may_be_left_out_or_not_is_refused() {
    // Two red ones, or none.
    let the_red = "put all small except the red on lego";
    let refused = moved(fixture::RED, the_red).unwrap_err();
    assert!(matches!(&refused, Refusal::Ambiguous { candidates, .. } if candidates.count() == 2));
    let the_lego = "put all small except the small red red lego on lego";
    assert!(moved(fixture::GREEN, the_lego).is_err());
    let no_green = "put all small near except the green near on lego";
    let refused = moved(fixture::RED, no_green);
    assert_eq!(refused, Ok([1, 3].into()));
    let objects = [objects(fixture::RED)[0], objects(fixture::RED)[2], lego()];
    let refused = plan_with(&fixture::with_exceptions(), &objects, no_green).unwrap_err();
    let Refusal::NoSuchObject { description, .. } = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(description.concepts(), [1]);
    // Nothing is left.
    let refused = moved(fixture::RED, "put all red except all small on lego").unwrap_err();
    assert_eq!(refused.kind(), "no_such_object");
    // Two that are not green.
    let refused = moved(fixture::RED, "put the small near that isn't green on lego").unwrap_err();
    assert_eq!(refused.kind(), "ambiguous");
}

#[test]
fn of_what_is_hidden_nothing_is_left_out_for_sure() {
    let [red, green, _, lego] = objects(fixture::RED);
    // On the green one: what that looks like is not seen.
    let mut over = fixture::object(5, 2, 2, 0.5, 0.5);
    over.location[4] -= fixture::EDGE_M;
    let objects = [red, green, over, lego];
    let plan = |sentence| plan_with(&fixture::with_exceptions(), &objects, sentence);
    for sentence in [
        "put all small except all red on lego",
        "put the small near that isn't red on lego",
    ] {
        assert_eq!(
            plan(sentence).unwrap_err().kind(),
            "ambiguous",
            "{sentence}"
        );
    }
}
