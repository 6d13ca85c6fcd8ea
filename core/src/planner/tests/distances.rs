//! Distances from the reference, and from where an object is, with the fixture in which `right` puts things 62.5 mm to the right, as it does
//! where demonstrations leave 20 mm between two.

use super::relations::{lego, plan_with, red};
use super::table::lifted;
use super::*;
use crate::scene::ObservedObject;

fn green(x: f32, y: f32) -> ObservedObject {
    fixture::object(1, fixture::GREEN, 2, x, y)
}

/// Where the first step puts its object: the middle of its box, and its place in the world.
fn put(sentence: &str) -> Result<([f32; 2], [f32; 3]), Refusal> {
    let objects = [green(0.5, 0.5), red(2, 0.9, 0.5), lego()];
    let plan = plan_with(&fixture::with_distances(), &objects, sentence)?;
    let step = plan.steps().first().unwrap();
    let [x1, y1, x2, y2, _] = step.location;
    let place = step.sub_goal.pose.translation.vector.into();
    Ok(([0.5 * (x1 + x2), 0.5 * (y1 + y2)], place))
}

#[test]
fn an_object_is_put_as_far_away_as_is_said() {
    let (usual, place) = put("put red right green").unwrap();
    assert_eq!(usual, [0.625, 0.5]);
    for (sentence, shift_m) in [
        ("put red 2 cm right green", 0.0),
        ("put red 5 cm right green", 0.03),
        ("put red 5 mm right green", -0.015),
        // The nearest free place beside it is that on the right, too.
        ("put red 5 cm from green", 0.03),
    ] {
        let (middle, there) = put(sentence).unwrap();
        // The image is 0.5 m wide, and its right is the world's −y.
        let expected = [usual[0] + 2.0 * shift_m, usual[1]];
        for (found, expected) in middle.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{sentence}: {middle:?}");
        }
        for (found, expected) in there.iter().zip([place[0], place[1] - shift_m, place[2]]) {
            assert!((found - expected).abs() < 1e-4, "{sentence}: {there:?}");
        }
    }
}

#[test]
fn a_distance_is_told_behind_the_reference() {
    let model = fixture::with_distances();
    let objects = [green(0.5, 0.5), red(2, 0.9, 0.5), lego()];
    let plan = plan_with(&model, &objects, "put red 5 cm right green").unwrap();
    let told = plan.explain(&model).to_string();
    assert!(
        told.contains("(id 1, score 1.00), at a distance of 50 mm; "),
        "{told}"
    );
}

#[test]
fn a_distance_from_what_carries_another_object_is_refused() {
    let tower = [
        green(0.5, 0.5),
        lifted(fixture::object(8, 2, 2, 0.5, 0.5)),
        red(2, 0.9, 0.5),
        lego(),
    ];
    let plan = |sentence| plan_with(&fixture::with_distances(), &tower, sentence);
    plan("put red right green").unwrap();
    let refused = plan("put red 5 cm right green").unwrap_err();
    assert_eq!(refused, Refusal::HiddenReference { step: 0, object: 1 });
    let refused = plan("put red 5 cm from green").unwrap_err();
    assert_eq!(refused, Refusal::HiddenReference { step: 0, object: 1 });
}

#[test]
fn a_distance_beyond_the_work_space_is_refused() {
    let refused = put("put red 900 mm right green").unwrap_err();
    assert_eq!(refused.kind(), "outside_work_space");
    let refused = put("put red 900 mm from green").unwrap_err();
    assert_eq!(refused, Refusal::NoRoomOnTable { step: 0, object: 2 });
}

#[test]
fn an_object_is_moved_by_a_distance_from_where_it_is() {
    let (_, [.., was_z]) = put("put red right green").unwrap();
    for (sentence, expected_m) in [("put red 5 cm right", 0.05), ("put red 5 mm right", 0.005)] {
        let (middle, [x, y, z]) = put(sentence).unwrap();
        let [was_x, was_y] = [0.5, -0.2];
        assert!(
            (middle[0] - (0.9 + 2.0 * expected_m)).abs() < 1e-4,
            "{middle:?}"
        );
        assert!((x - was_x).abs() < 1e-4 && (y - (was_y - expected_m)).abs() < 1e-4);
        assert!((z - was_z).abs() < 1e-4);
    }
    let model = fixture::with_distances();
    let objects = [green(0.5, 0.5), red(2, 0.6, 0.5), lego()];
    let plan = plan_with(&model, &objects, "put red 5 cm right").unwrap();
    let told = plan.explain(&model).to_string();
    let expected = "move the red object (id 2, score 1.00) right where it is, by 50 mm; ";
    assert!(told.contains(expected), "{told}");
}

#[test]
fn each_of_several_objects_is_moved_from_where_it_is() {
    let objects = [green(0.5, 0.5), red(2, 0.2, 0.5), red(3, 0.4, 0.2), lego()];
    let plan = plan_with(
        &fixture::with_distances(),
        &objects,
        "put all red 5 cm right",
    )
    .unwrap();
    let moved = plan.steps().iter().map(|step| {
        let [x1, _, x2, ..] = step.location;
        (step.object.object, 0.5 * (x1 + x2))
    });
    for ((object, x), (expected, expected_x)) in moved.zip([(2, 0.3), (3, 0.5)]) {
        assert_eq!(object, expected);
        assert!((x - expected_x).abs() < 1e-4, "{x}");
    }
    assert_eq!(plan.steps().len(), 2);
}

#[test]
fn what_stands_on_another_object_is_not_shifted() {
    let tower = [
        green(0.5, 0.5),
        lifted(fixture::object(2, fixture::RED, 2, 0.5, 0.5)),
        lego(),
    ];
    let plan = |sentence| plan_with(&fixture::with_distances(), &tower, sentence);
    let refused = plan("put red 5 cm right").unwrap_err();
    assert_eq!(refused, Refusal::NotOnTable { step: 0, object: 2 });
    // It moves what it carries, too.
    let refused = plan("put green 5 cm right").unwrap_err();
    assert_eq!(refused, Refusal::HiddenReference { step: 0, object: 1 });
}
