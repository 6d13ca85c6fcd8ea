//! Actions that are made of others, with the fixture that has some: `by` puts to the right by an eighth of the
//! image, or up by a sixteenth, where `on` does; `diagonally` does both, and `by the` is a relation.

use super::relations::{lego, meant, plan_with, red};
use super::table::lifted;
use super::*;
use crate::scene::ObservedObject;

fn green(x: f32, y: f32) -> ObservedObject {
    fixture::object(1, fixture::GREEN, 2, x, y)
}

fn plan(objects: &[ObservedObject], sentence: &str) -> Result<Plan, Refusal> {
    plan_with(&fixture::with_compounds(), objects, sentence)
}

/// Where the first step puts its object, and by which action.
fn put(objects: &[ObservedObject], sentence: &str) -> ([f32; 2], &'static str) {
    let plan = plan(objects, sentence).unwrap();
    let [step] = plan.steps() else {
        panic!("{plan:?}");
    };
    let [x1, y1, x2, y2, _] = step.location;
    let actions = fixture::with_compounds().actions;
    let name = actions
        .get(usize::from(step.action))
        .map_or("", |action| action.name);
    ([0.5 * (x1 + x2), 0.5 * (y1 + y2)], name)
}

#[test]
fn what_is_put_next_to_an_object_goes_to_the_nearest_free_place_there() {
    let model = fixture::with_compounds();
    let objects = |x, y| [green(0.5, 0.5), red(2, x, y), lego()];
    let beside = |x, y| put(&objects(x, y), "put red by green");
    assert_eq!(beside(0.9, 0.5), ([0.625, 0.5], "MoveRight"));
    assert_eq!(beside(0.3, 0.2), ([0.5, 0.4375], "MoveOn"));
    let plan = plan(&objects(0.9, 0.5), "put red by green").unwrap();
    assert_eq!(meant(&plan), (2, 1));
    let notation = plan.program().notation(&model).to_string();
    let expected = "Action(NextTo, Unique(Filter(red, Scene())), Unique(Filter(green, Scene())))";
    assert_eq!(notation, expected);
    let explained = plan.explain(&model).to_string();
    let text = "the red object (id 2, score 1.00) NextTo the green object (id 1, score 1.00), to the right of it; ";
    assert!(explained.contains(text), "{explained}");
}

#[test]
fn a_place_beside_it_that_is_taken_is_left_free() {
    let with = |other| [green(0.5, 0.5), red(2, 0.9, 0.5), other];
    let at = |x, y| fixture::object(9, 2, 2, x, y);
    // Right of it, above it, and both.
    let above = put(&with(at(0.7, 0.5)), "put red by green");
    assert_eq!(above, ([0.5, 0.4375], "MoveOn"));
    let right = put(&with(at(0.5, 0.35)), "put red by green");
    assert_eq!(right, ([0.625, 0.5], "MoveRight"));
    let refused = plan(&with(at(0.55, 0.44)), "put red by green").unwrap_err();
    assert_eq!(refused, Refusal::NoRoomOnTable { step: 0, object: 2 });
    // Beside what stands on another one, no demonstration puts anything.
    let tower = [lifted(green(0.5, 0.5)), red(2, 0.9, 0.5), at(0.5, 0.5)];
    let refused = plan(&tower, "put red by green").unwrap_err();
    assert_eq!(refused, Refusal::NoRoomOnTable { step: 0, object: 2 });
}

#[test]
fn what_all_parts_say_is_done_one_after_the_other() {
    let objects = [green(0.5, 0.5), red(2, 0.2, 0.2), lego()];
    assert_eq!(
        put(&objects, "put red diagonally green"),
        ([0.625, 0.4375], "")
    );
    let planned = plan(&objects, "put red diagonally green").unwrap();
    let action = planned.steps()[0].action;
    let model = fixture::with_compounds();
    assert_eq!(
        model.compound(action).map(|compound| compound.name),
        Some("RightOn")
    );
}

#[test]
fn next_to_is_what_lies_near_in_whatever_direction() {
    let found = |objects: &[ObservedObject]| {
        plan(objects, "put red by the green on lego").map(|plan| meant(&plan).0)
    };
    let far = red(3, 0.9, 0.9);
    for (x, y) in [(0.5, 0.63), (0.5, 0.37), (0.63, 0.5), (0.37, 0.5)] {
        let objects = [green(0.5, 0.5), red(2, x, y), far, lego()];
        assert_eq!(found(&objects), Ok(2), "({x}, {y})");
    }
    let both = [
        green(0.5, 0.5),
        red(2, 0.63, 0.5),
        red(3, 0.37, 0.5),
        lego(),
    ];
    assert_eq!(found(&both).unwrap_err().kind(), "ambiguous");
    let none = [green(0.5, 0.5), far, lego()];
    assert_eq!(found(&none).unwrap_err().kind(), "no_such_object");
}
