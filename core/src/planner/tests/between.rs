//! What is put or lies between two objects, with the fixture in which `amid` puts there, as far from each as `right` needs,
//! and `amidst` is a relation.

use super::relations::{meant, plan_with, red};
use super::table::lifted;
use super::*;
use crate::scene::ObservedObject;

fn green(x: f32, y: f32) -> ObservedObject {
    fixture::object(1, fixture::GREEN, 2, x, y)
}

fn lego(x: f32, y: f32) -> ObservedObject {
    fixture::object(9, 2, fixture::LEGO, x, y)
}

fn plan(objects: &[ObservedObject], sentence: &str) -> Result<Plan, Refusal> {
    plan_with(&fixture::with_between(), objects, sentence)
}

const AMID: &str = "put red amid the green and the lego";

#[test]
fn an_object_is_put_halfway_between_two() {
    let model = fixture::with_between();
    for (one, other, middle) in [
        ((0.3, 0.5), (0.7, 0.5), [0.5, 0.5]),
        ((0.5, 0.2), (0.5, 0.6), [0.5, 0.4]),
        ((0.7, 0.2), (0.3, 0.7), [0.5, 0.45]),
    ] {
        let objects = [
            green(one.0, one.1),
            lego(other.0, other.1),
            red(2, 0.9, 0.9),
        ];
        let planned = plan(&objects, AMID).unwrap();
        let [step] = planned.steps() else {
            panic!("{planned:?}");
        };
        let [x1, y1, x2, y2, _] = step.location;
        let got = [0.5 * (x1 + x2), 0.5 * (y1 + y2)];
        assert!(
            got.iter()
                .zip(middle)
                .all(|(got, expected)| (got - expected).abs() < 1e-4),
            "{got:?}"
        );
        assert_eq!(meant(&planned), (2, 1));
        assert_eq!(step.reference.anchors(), [9]);
        let notation = planned.program().notation(&model).to_string();
        let expected = "Action(Amid, Unique(Filter(red, Scene())), \
                        Unique(Filter(green, Relate(And, Unique(Filter(lego, Scene()))))))";
        assert_eq!(notation, expected);
        let told = planned.explain(&model).to_string();
        assert!(
            told.contains("between the green object and the lego object (id 1, score 1.00); "),
            "{told}"
        );
    }
}

#[test]
fn without_room_it_is_refused() {
    let refused = |objects: &[ObservedObject]| plan(objects, AMID).unwrap_err();
    let no_room = Refusal::NoRoomOnTable { step: 0, object: 2 };
    // The image is 0.5 m wide; 52.5 mm are needed on each side.
    let apart = |x| [green(0.3, 0.5), lego(x, 0.5), red(2, 0.9, 0.9)];
    assert_eq!(refused(&apart(0.5)), no_room);
    plan(&apart(0.52), AMID).unwrap();
    // Something stands there, or beside it.
    let [one, other, moved] = apart(0.9);
    for (x, y) in [(0.6, 0.5), (0.6, 0.58)] {
        let taken = [one, other, moved, fixture::object(4, 2, 2, x, y)];
        assert_eq!(refused(&taken), no_room, "({x}, {y})");
    }
    // One of them stands on another object.
    let tower = [
        green(0.3, 0.5),
        lifted(lego(0.8, 0.5)),
        moved,
        fixture::object(4, 2, 2, 0.8, 0.5),
    ];
    assert_eq!(refused(&tower), Refusal::NotOnTable { step: 0, object: 9 });
    // One of them is seen in part.
    let covered = [
        green(0.3, 0.5),
        other,
        moved,
        lifted(fixture::object(4, 2, 2, 0.3, 0.5)),
    ];
    assert_eq!(
        refused(&covered),
        Refusal::HiddenReference { step: 0, object: 1 }
    );
}

#[test]
fn nothing_is_put_between_itself_and_another_object() {
    let objects = [green(0.3, 0.5), lego(0.9, 0.5), red(2, 0.9, 0.9)];
    let refused = plan(&objects, "put red amid the green and the red").unwrap_err();
    assert_eq!(refused, Refusal::SameObject { step: 0, object: 2 });
    let refused = plan(&objects, "put red amid the red and the green").unwrap_err();
    assert_eq!(refused, Refusal::SameObject { step: 0, object: 2 });
    // The two are different ones.
    let refused = plan(&objects, "put red amid the green and the green").unwrap_err();
    assert_eq!(refused.kind(), "no_such_object");
}

#[test]
fn what_lies_between_two_is_described_so() {
    let found = |objects: &[ObservedObject]| {
        plan(objects, "put red amidst the green and the lego right lego").map(|plan| meant(&plan).0)
    };
    let ends = [green(0.2, 0.5), lego(0.6, 0.5)];
    for (x, y) in [(0.4, 0.5), (0.3, 0.52), (0.5, 0.45)] {
        let objects = [ends[0], ends[1], red(2, x, y), red(3, 0.1, 0.1)];
        assert_eq!(found(&objects), Ok(2), "({x}, {y})");
    }
    let none = [ends[0], ends[1], red(2, 0.4, 0.8), red(3, 0.9, 0.5)];
    assert_eq!(found(&none).unwrap_err().kind(), "no_such_object");
    let both = [ends[0], ends[1], red(2, 0.4, 0.5), red(3, 0.5, 0.5)];
    assert_eq!(found(&both).unwrap_err().kind(), "ambiguous");
}

#[test]
fn other_words_for_two_objects_mean_nothing() {
    let objects = [green(0.3, 0.5), lego(0.9, 0.5), red(2, 0.9, 0.9)];
    for sentence in [
        "put red amid green",
        "put red amid green lego",
        "put red right green and lego",
        "put red amid green right lego and red",
        "put all red amid the green and the lego",
        "put red 2 cm amid the green and the lego",
    ] {
        let refusal = plan(&objects, sentence).map(|plan| std::format!("{plan:?}"));
        assert!(refusal.is_err(), "{sentence}: {refusal:?}");
    }
}
