//! "On the table", with the fixture that has one: a place to the right of another object.

use std::vec::Vec;

use super::relations::{lego, plan_with, red};
use super::*;
use crate::scene::ObservedObject;

/// Object 1, green, in the middle.
fn green() -> ObservedObject {
    fixture::object(1, fixture::GREEN, 2, 0.5, 0.5)
}

/// The same object, on what stands below it.
pub(super) fn lifted(mut object: ObservedObject) -> ObservedObject {
    let [.., depth_m] = &mut object.location;
    let nearer = *depth_m / (*depth_m - fixture::EDGE_M);
    *depth_m -= fixture::EDGE_M;
    for corner in &mut object.location[..4] {
        *corner = 0.5 + nearer * (*corner - 0.5);
    }
    object
}

fn plan(objects: &[ObservedObject], sentence: &str) -> Result<Plan, Refusal> {
    plan_with(&fixture::with_table(), objects, sentence)
}

fn refusal(objects: &[ObservedObject], sentence: &str) -> (&'static str, String) {
    let model = fixture::with_table();
    let refusal = plan(objects, sentence).unwrap_err();
    let message = refusal.in_context(&model, sentence).to_string();
    (refusal.kind(), message)
}

/// Ids of the object and of the one beside which it is put, of each step.
fn moved(plan: &Plan) -> Vec<(u32, u32)> {
    let steps = plan.steps().iter();
    let pair = |step: &PlannedStep| (step.object.object, step.reference.object);
    steps.map(pair).collect()
}

#[test]
fn what_is_put_on_the_table_stands_beside_the_nearest_object_with_room() {
    let model = fixture::with_table();
    let small = fixture::object(5, 2, fixture::SMALL, 0.3, 0.8);
    let objects = [green(), lifted(red(2, 0.5, 0.5)), lego(), small];
    let plan = plan(&objects, "put red on the desk").unwrap();
    assert_eq!(moved(&plan), [(2, 5)]);
    assert_eq!(
        plan.program().notation(&model).to_string(),
        "Action(MoveOn, Unique(Filter(red, Scene())), Table())"
    );
    let explained = plan.explain(&model).to_string();
    assert!(
        explained.starts_with(
            "Step 1: move the red object (id 2, score 1.00) on the table, to the right of object 5; "
        ),
        "{explained}"
    );
    let [step] = plan.steps() else {
        panic!("{plan:?}");
    };
    assert_eq!(model.actions[usize::from(step.action)].name, "MoveRight");
    let [x, y, z]: [f32; 3] = step.sub_goal.pose.translation.vector.into();
    assert!(close(
        &[x, y, z],
        &[0.5 - 0.15, 0.1 - fixture::EDGE_M, 0.5 * fixture::EDGE_M]
    ));
}

#[test]
fn what_carries_another_object_is_seen_in_part_and_comes_last() {
    let tower = [green(), lifted(red(2, 0.5, 0.5))];
    let alone = plan(&tower, "put red on desk").unwrap();
    assert_eq!(moved(&alone), [(2, 1)]);
    let other = plan(&[tower[0], tower[1], lego()], "put red on desk").unwrap();
    assert_eq!(moved(&other), [(2, 9)]);
    // What it carries is not in the way; beside the green one ends the work space.
    let mut model = fixture::with_table();
    model.header.work_space.min[1] = -0.1;
    let carried = lifted(fixture::object(3, 2, fixture::SMALL, 0.5, 0.5));
    let objects = [
        fixture::object(1, fixture::GREEN, 2, 0.8, 0.5),
        lifted(red(2, 0.8, 0.5)),
        fixture::object(9, 2, fixture::LEGO, 0.5, 0.5),
        carried,
    ];
    let found = plan_with(&model, &objects, "put red on desk").unwrap();
    assert_eq!(moved(&found), [(2, 9)]);
}

#[test]
fn a_place_that_is_taken_hidden_or_outside_is_not_free() {
    let tower = [green(), lifted(red(2, 0.5, 0.5))];
    let at = |x: f32, y: f32| fixture::object(5, 2, fixture::SMALL, x, y);
    // To the right of the lego one, or else of the other.
    let lego = || fixture::object(9, 2, fixture::LEGO, 0.5, 0.8);
    let beside = |other: ObservedObject| {
        let objects = [tower[0], tower[1], other, lego()];
        plan(&objects, "put red on desk").map(|plan| moved(&plan))
    };
    assert_eq!(beside(at(0.8, 0.8)), Ok([(2, 9)].into()));
    // In the place itself, and too near to it.
    assert_eq!(beside(at(0.625, 0.8)), Ok([(2, 5)].into()));
    assert_eq!(beside(at(0.75, 0.8)), Ok([(2, 5)].into()));
    // In front of it, high above the table.
    let mut above = at(0.65, 0.85);
    above.location[4] = 0.3;
    assert_eq!(beside(above), Ok([(2, 1)].into()));
    // Beyond the work space.
    let mut model = fixture::with_table();
    model.header.work_space.min[1] = -0.05;
    let refused = plan_with(&model, &tower, "put red on desk").unwrap_err();
    assert_eq!(refused.kind(), "no_room_on_table");
    assert_eq!(
        refused.in_context(&model, "").to_string(),
        "step 1: no free place on the table is in sight for object 2; say on which side of which object to put it"
    );
}

#[test]
fn what_stands_there_already_is_refused_by_name() {
    let objects = [green(), red(2, 0.2, 0.5)];
    let (kind, message) = refusal(&objects, "put red on desk");
    assert_eq!(kind, "already_on_table");
    assert_eq!(
        message,
        "step 1: object 2 stands on the table already; describe another one"
    );
    assert_eq!(refusal(&objects, "put all red on desk").0, kind);
}

#[test]
fn all_of_them_are_put_there_one_beside_another() {
    let objects = [
        green(),
        lifted(red(2, 0.5, 0.5)),
        fixture::object(9, 2, fixture::LEGO, 0.3, 0.2),
        lifted(red(3, 0.3, 0.2)),
        red(4, 0.9, 0.9),
    ];
    let model = fixture::with_table();
    let plan = plan(&objects, "put all red on desk").unwrap();
    assert_eq!(moved(&plan), [(2, 1), (3, 2)]);
    let each = "Action(MoveOn, Each(Filter(red, Scene())), Table())";
    assert_eq!(
        plan.program().notation(&model).to_string(),
        std::format!("{each}\n{each}")
    );
}

#[test]
fn an_object_may_be_described_by_standing_there() {
    let objects = [green(), lifted(red(2, 0.5, 0.5)), red(3, 0.2, 0.2), lego()];
    let plan = plan(&objects, "put red above desk on lego").unwrap();
    assert_eq!(moved(&plan), [(3, 9)]);
    assert_eq!(
        plan.program().notation(&fixture::with_table()).to_string(),
        "Action(MoveOn, Unique(Filter(red, Relate(MoveOn, Table()))), Unique(Filter(lego, Scene())))"
    );
    let (kind, _) = refusal(&objects[..2], "put red above desk on green");
    assert_eq!(kind, "no_such_object");
}

#[test]
fn what_was_put_there_stands_there_in_later_steps() {
    let objects = [green(), lifted(red(2, 0.5, 0.5)), lego()];
    let plan = plan(&objects, "put red on desk then put red above desk on green").unwrap();
    assert_eq!(moved(&plan), [(2, 9), (2, 1)]);
}
