//! What others hide a part of: its colour is told by the rest, and its size by its width.

use super::relations::{OTHER, lego, meant, plan, plan_with, red, refusal};
use super::*;
use crate::model::Concept;
use crate::scene::ObservedObject;

/// Object 3 to the right of the others, and a nearer one that overlaps more than half of it.
fn hidden(color: usize, size: usize) -> [ObservedObject; 2] {
    let mut front = fixture::object(4, OTHER, OTHER, 0.75, 0.55);
    front.location[4] -= 0.05;
    [fixture::object(3, color, size, 0.75, 0.5), front]
}

#[test]
fn its_colour_is_told() {
    let sentence = "put rightmost red on lego";
    let among = |[object, front]: [ObservedObject; 2]| {
        [red(1, 0.3, 0.5), red(2, 0.5, 0.5), object, front, lego()]
    };
    // Another colour, the same, and none that is known.
    let objects = among(hidden(fixture::GREEN, OTHER));
    assert_eq!(meant(&plan(&objects, sentence).unwrap()), (2, 9));
    let objects = among(hidden(fixture::RED, OTHER));
    assert_eq!(meant(&plan(&objects, sentence).unwrap()), (3, 9));
    let (refused, _) = refusal(&among(hidden(OTHER, OTHER)), sentence);
    assert!(matches!(refused, Refusal::Ambiguous { .. }), "{refused:?}");
    // Hardly anything of it is seen.
    let mut objects = among(hidden(fixture::GREEN, OTHER));
    objects[3].location = objects[2].location;
    objects[3].location[4] -= 0.05;
    let (refused, _) = refusal(&objects, sentence);
    assert!(matches!(refused, Refusal::Ambiguous { .. }), "{refused:?}");
}

#[test]
fn all_of_a_colour_are_told() {
    let reference = fixture::object(9, OTHER, fixture::LEGO, 0.1, 0.9);
    let three = [red(1, 0.3, 0.5), red(2, 0.5, 0.5), reference];
    let count = |color| {
        let [object, front] = hidden(color, OTHER);
        let [one, two, lego] = three;
        let plan = plan(&[one, two, object, front, lego], "put all red on lego");
        plan.unwrap().steps().len()
    };
    assert_eq!([count(fixture::GREEN), count(fixture::RED)], [2, 3]);
}

/// The fixture's concepts, with small objects that never look as wide as the others.
fn concepts() -> [Concept<'static>; 4] {
    let mut concepts = [0, 1, 2, 3].map(|concept| fixture::related().concepts[concept]);
    concepts[3].edges_m = Some([0.56 * fixture::EDGE_M; 3]);
    concepts
}

#[test]
fn its_size_is_told_by_its_width() {
    let concepts = concepts();
    let model = fixture::related().with_concepts(&concepts);
    let green = fixture::object(1, fixture::GREEN, fixture::LEGO, 0.3, 0.5);
    // It looks small, and is too wide for that.
    let [object, front] = hidden(fixture::RED, fixture::SMALL);
    let seen = |sentence| plan_with(&model, &[green, object, front], sentence);
    assert_eq!(meant(&seen("put red lego on green").unwrap()), (3, 1));
    let refused = seen("put small on green").unwrap_err();
    assert!(
        matches!(refused, Refusal::NoSuchObject { .. }),
        "{refused:?}"
    );
    assert_eq!(meant(&seen("put rightmost lego on green").unwrap()), (3, 1));
    // If a side of it is hidden, it may be wider than it looks, but no narrower.
    let mut narrow = [object, front];
    narrow[0].location[2] -= 0.055;
    let x = narrow[0].location[2];
    (narrow[1].location[0], narrow[1].location[2]) = (x, x + 0.125);
    let [object, front] = narrow;
    let seen = |sentence| plan_with(&model, &[green, object, front], sentence);
    let refused = seen("put rightmost lego on green").unwrap_err();
    assert!(matches!(refused, Refusal::Ambiguous { .. }), "{refused:?}");
}

#[test]
fn the_largest_is_told_by_its_width_too() {
    let concepts = concepts();
    let model = fixture::related().with_concepts(&concepts);
    let green = fixture::object(9, fixture::GREEN, fixture::LEGO, 0.1, 0.1);
    let mut small = fixture::object(1, fixture::RED, fixture::SMALL, 0.3, 0.5);
    small.location = [0.265, 0.465, 0.335, 0.535, 0.5];
    let [object, front] = hidden(fixture::RED, fixture::SMALL);
    let objects = [small, object, front, green];
    let largest = plan_with(&model, &objects, "put largest red on green");
    assert_eq!(meant(&largest.unwrap()), (3, 9));
    let smallest = plan_with(&model, &objects, "put smallest red on green");
    assert_eq!(meant(&smallest.unwrap()), (1, 9));
}
