//! How objects stand to each other. The paper has no relations inside a description; these are
//! further rows of its Table II.
//!
//! By what actions bring about, "left of" is where `MoveLeft` puts things:
//!
//! * `Relate(k, y)` → `cos(p_i − y, x_i − y)` for each object `i`, and −1 for `y` itself, where
//!   `x_i` and `y` are the centres of the object and of the anchor, and `p_i` is the centre of the
//!   object after action `k` with the anchor as reference, all in metres.
//!
//! So an object is in a relation as far as it lies in the direction in which the action would put
//! it. Nothing is trained for it: the learned simulator knows what each action brings about, and the
//! actions of another domain are relations at once. How far away the object is does not matter.
//!
//! By compounds of actions: "in front and to the left of" is where both put things, one after the other, and
//! "next to" is what lies near in whatever direction:
//!
//! * `Relate(any, y)` → for each object `i` that is level with `y`, from 1 where `|x_i − y|` is
//!   at most `1.25·d` down to −1 where it is `1.75·d`, with the distance `d = |p − y|` of where the first of the
//!   actions would put it; −1 for all others.
//!
//! By superlatives, "nearest to" and "farthest from", which compare:
//!
//! * `Relate(Nearest, y)` → of the objects that fit all filters, except `y`, those with
//!   `|x_i − y| < 1.2·min_j |x_j − y|`;
//! * `Relate(Farthest, y)` → those with `1.2·|x_i − y| > max_j |x_j − y|`.
//!
//! So there is one object, or it is not clear which is meant. Distances are between centres, in
//! space: a block on the anchor touches it as one beside it does. Nothing is trained for them
//! either; which words mean them is learned.
//!
//! By extremes, "leftmost" and "largest", which compare without an anchor:
//!
//! * `Extreme(scores, k)` → of the objects that fit, those with `max_j d·x_j − d·x_i < 20 mm`, where
//!   `d` is the [`direction`] in which action `k` puts things in the middle of the work space;
//! * `Extreme(scores, Largest)` → those with `1.2·v_i > max_j v_j`, where `v` is the volume of the
//!   size that an object shows, and those that show none; `Smallest` likewise.

use nalgebra::Point3;

use crate::action::{simulate, simulate_any};
use crate::model::{Action, Compound, CompoundKind, LOCATION, Model};
use crate::nn::dot;
use crate::viewpoint::Viewpoint;

/// The least cosine at which an object is clearly in a relation: that of 40°, less than halfway
/// between two directions at right angles.
pub const RELATION_CLEAR: f32 = 0.766;

/// The least ratio of two distances at which the shorter one is clearly shorter.
pub const CLEARLY_NEARER: f32 = 1.2;

/// The least distance by which an object that lies farther in a direction clearly does, metres.
pub const CLEARLY_FARTHER_M: f32 = 0.02;

/// The least ratio of two volumes at which the larger one is clearly larger.
pub const CLEARLY_LARGER: f32 = 1.2;

/// Ratios of the distance to an anchor, and that at which an action would put an object beside it, up to which
/// the object is next to the anchor, and from which on it is not.
pub const NEXT_TO: [f32; 2] = [1.25, 1.75];

/// The greatest share of the height in the distance of objects that are next to each other: the sine of
/// 30°, less than halfway to one that stands on the other.
pub const LEVEL: f32 = 0.5;

/// A shorter vector has no direction, metres.
const LEAST_LENGTH_M: f32 = 1e-6;

/// How clearly an object is in a relation to an anchor: the cosine between the directions in which
/// it lies, and in which the action would put it. −1 if one of them has no length; `None` if a
/// number is not finite, and for an index that is none. Next to the anchor, see the module.
///
/// * `action`: of an action or a compound, as of [`crate::dsl::RelationKind::Action`]
/// * `object`, `anchor`: locations as [`Viewpoint::to_training`] gives them
///
/// Cost: up to two [`simulate`], three deprojections and two square roots.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::relation::relate;
/// use nsrm_core::viewpoint::Viewpoint;
/// use nsrm_tabletop::TABLETOP;
///
/// # let scene = scene(&TABLETOP);
/// let viewpoint = Viewpoint::new(&TABLETOP, scene.camera());
/// let seen = |index: usize| viewpoint.to_training(&scene.objects()[index].location);
/// let (one, other) = (seen(0), seen(1));
/// let [left, right] = ["MoveLeft", "MoveRight"].map(|name| {
///     let mut actions = TABLETOP.actions.iter();
///     let action = actions.position(|action| action.name == name).expect("an action") as u8;
///     relate(&TABLETOP, &viewpoint, action, &one, &other).expect("finite")
/// });
/// assert!(left * right < 0.0); // it lies on one side
/// # Ok(())
/// # }
/// ```
pub fn relate(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    action: u8,
    object: &[f32; LOCATION],
    anchor: &[f32; LOCATION],
) -> Option<f32> {
    let is_any = |compound: &&Compound<'_>| compound.kind == CompoundKind::Any;
    if let Some(compound) = model.compound(action).filter(is_any) {
        let put = simulate_any(model, *compound.parts.first()?, object, anchor)?;
        return near(model, viewpoint, object, &put, anchor);
    }
    let put = simulate_any(model, action, object, anchor)?;
    towards(model, viewpoint, object, &put, anchor)
}

/// How clearly an object lies between two others: −1 where both lie in the same direction from it, 1 on the line from one
/// to the other; as [`relate`] otherwise.
///
/// Cost: three deprojections and two square roots.
pub fn between(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    object: &[f32; LOCATION],
    anchors: [&[f32; LOCATION]; 2],
) -> Option<f32> {
    let origin = centre(model, viewpoint, object);
    let directions = anchors.map(|anchor| (centre(model, viewpoint, anchor) - origin).into());
    Some(cosine(directions)?.map_or(-1.0, |cosine| -cosine))
}

/// The cosine between the directions from an anchor to an object, and to where it would be put.
fn towards(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    object: &[f32; LOCATION],
    put: &[f32; LOCATION],
    anchor: &[f32; LOCATION],
) -> Option<f32> {
    // An angle is the same in the camera's frame and in the world's.
    let origin = centre(model, viewpoint, anchor);
    let directions = [put, object].map(|end| (centre(model, viewpoint, end) - origin).into());
    Some(cosine(directions)?.unwrap_or(-1.0))
}

/// The cosine between two directions; `None` within if one of them has no length, and without if it is not finite.
fn cosine(directions: [[f32; 3]; 2]) -> Option<Option<f32>> {
    let lengths = directions.map(|direction| length(&direction));
    if !lengths.iter().all(|length| length.is_finite()) {
        return None;
    }
    if lengths.iter().any(|length| *length < LEAST_LENGTH_M) {
        return Some(None);
    }
    let ([one, other], [one_m, other_m]) = (directions, lengths);
    // One after the other: their product may overflow.
    let cosine = dot(&one.map(|x| x / one_m), &other.map(|x| x / other_m));
    cosine.is_finite().then_some(Some(cosine))
}

/// How clearly an object is next to an anchor; `None` if a number is not finite.
///
/// * `put`: where an action would put it there
fn near(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    object: &[f32; LOCATION],
    put: &[f32; LOCATION],
    anchor: &[f32; LOCATION],
) -> Option<f32> {
    let place = |location| viewpoint.training().locate(model.camera, location);
    let origin = place(anchor);
    let [x, y, z]: [f32; 3] = (place(object) - origin).into();
    let [is_m, would_be_m] =
        [[x, y, z], (place(put) - origin).into()].map(|vector| length(&vector));
    if !is_m.is_finite() || !would_be_m.is_finite() {
        return None;
    }
    let [full, none] = NEXT_TO;
    if would_be_m.min(is_m) < LEAST_LENGTH_M || libm::fabsf(z) > LEVEL * is_m {
        return Some(-1.0);
    }
    let share = (is_m / would_be_m - full) / (none - full);
    Some((1.0 - 2.0 * share).clamp(-1.0, 1.0))
}

/// The direction in which an action puts things: from an object to where the action would put it with
/// itself as reference, a unit vector in the world. As the table is level, it is vertical or
/// horizontal, whichever is nearer. `None` if it has no length or is not finite.
///
/// * `object`: a location as [`Viewpoint::to_training`] gives it
///
/// Cost: one [`simulate`], two deprojections and a square root.
pub fn direction(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    action: &Action<'_>,
    object: &[f32; LOCATION],
) -> Option<[f32; 3]> {
    let camera = viewpoint.training();
    let put = simulate(model.simulator, action, object, object);
    let moved = camera.locate(model.camera, &put) - camera.locate(model.camera, object);
    let [x, y, z]: [f32; 3] = moved.into();
    let moved = if z * z > x * x + y * y {
        [0.0, 0.0, z]
    } else {
        [x, y, 0.0]
    };
    let length_m = length(&moved);
    (length_m.is_finite() && length_m >= LEAST_LENGTH_M).then(|| moved.map(|x| x / length_m))
}

/// How far the centre of an object is from that of an anchor, metres; `None` if it is not finite.
///
/// * `object`, `anchor`: locations as [`Viewpoint::to_training`] gives them
///
/// Cost: two deprojections and a square root.
pub fn distance(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    object: &[f32; LOCATION],
    anchor: &[f32; LOCATION],
) -> Option<f32> {
    let [object, anchor] = [object, anchor].map(|location| centre(model, viewpoint, location));
    let length_m = length(&(object - anchor).into());
    length_m.is_finite().then_some(length_m)
}

/// The centre of an object in the frame of the training's camera, metres.
fn centre(model: &Model<'_>, viewpoint: &Viewpoint<'_>, location: &[f32; LOCATION]) -> Point3<f32> {
    viewpoint
        .training()
        .locate_in_camera(model.camera, location)
}

fn length(vector: &[f32; 3]) -> f32 {
    libm::sqrtf(dot(vector, vector))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::model::Simulator;

    /// A box around a point of the image, at 0.5 m.
    const fn at(x: f32, y: f32) -> [f32; LOCATION] {
        [x - 0.0625, y - 0.0625, x + 0.0625, y + 0.0625, 0.5]
    }

    /// Of an object at (`x`, `y`) to one in the middle of the image.
    fn to_the_middle(model: &Model<'_>, action: u8, x: f32, y: f32) -> Option<f32> {
        let viewpoint = Viewpoint::new(model, &fixture::camera());
        relate(model, &viewpoint, action, &at(x, y), &at(0.5, 0.5))
    }

    fn right_of_the_middle(x: f32, y: f32) -> Option<f32> {
        to_the_middle(&fixture::model(), 1, x, y)
    }

    #[test]
    fn it_is_the_cosine_to_where_the_action_would_put_it() {
        // The image is as high as it is wide in metres, so angles in it are those on the table.
        for (x, y, expected) in [
            (0.75, 0.5, 1.0),
            (0.98, 0.5, 1.0),
            (0.75, 0.75, core::f32::consts::FRAC_1_SQRT_2),
            (0.5, 0.75, 0.0),
            (0.25, 0.5, -1.0),
            // (4, 3) of length 5.
            (0.9, 0.2, 0.8),
        ] {
            let got = right_of_the_middle(x, y).unwrap();
            assert!((got - expected).abs() < 1e-5, "({x}, {y}): {got}");
        }
        assert!((0.766..0.8).contains(&RELATION_CLEAR));
        assert!((libm::acosf(RELATION_CLEAR).to_degrees() - 40.0).abs() < 0.05);
    }

    #[test]
    fn what_stands_higher_is_in_the_relation_of_what_is_moved_higher() {
        let model = fixture::model();
        let on = |y| to_the_middle(&model, 0, 0.5, y).unwrap();
        assert!((on(0.25) - 1.0).abs() < 1e-5);
        assert!((on(0.75) + 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_distance_is_in_space_and_the_same_both_ways() {
        let model = fixture::model();
        let viewpoint = Viewpoint::new(&model, &fixture::camera());
        let between = |one: &[f32; LOCATION], other: &[f32; LOCATION]| {
            distance(&model, &viewpoint, one, other).unwrap()
        };
        let middle = at(0.5, 0.5);
        // At 0.5 m the image is 0.5 m wide and high.
        for (x, y, raised_m, expected_m) in [
            (0.5, 0.5, 0.0, 0.0),
            (0.9, 0.5, 0.0, 0.2),
            (0.9, 0.2, 0.0, 0.25),
            (0.5, 0.5, 0.06, 0.06),
        ] {
            let mut object = at(x, y);
            object[4] -= raised_m;
            let got = between(&object, &middle);
            assert!((got - expected_m).abs() < 1e-6, "({x}, {y}): {got}");
            assert_eq!(got, between(&middle, &object));
        }
        let broken = [f32::MAX; LOCATION];
        assert_eq!(distance(&model, &viewpoint, &broken, &middle), None);
    }

    #[test]
    fn what_has_no_direction_is_in_no_relation() {
        assert_eq!(right_of_the_middle(0.5, 0.5), Some(-1.0));
        // An action that puts the object where the anchor is.
        let mut model = fixture::model();
        let still = Simulator {
            output: fixture::linear(),
            ..*model.simulator
        };
        model.simulator = &still;
        assert_eq!(to_the_middle(&model, 1, 0.75, 0.5), Some(-1.0));
    }

    #[test]
    fn numbers_that_are_not_finite_give_no_score() {
        for broken in [f32::NAN, f32::INFINITY, f32::MAX] {
            let mut simulator = *fixture::model().simulator;
            simulator.output.bias[4] = broken;
            let model = Model {
                simulator: &simulator,
                ..fixture::model()
            };
            assert_eq!(to_the_middle(&model, 1, 0.75, 0.5), None, "{broken}");
        }
    }

    #[test]
    fn next_to_is_near_and_level_whatever_the_direction() {
        let model = fixture::with_compounds();
        let viewpoint = Viewpoint::new(&model, &fixture::camera());
        // Of the fixture's, the first puts things 0.0625 m to the right.
        let any = model.actions.len() as u8;
        let near = |x: f32, y: f32, raised_m: f32| {
            let mut object = at(x, y);
            object[4] -= raised_m;
            relate(&model, &viewpoint, any, &object, &at(0.5, 0.5)).unwrap()
        };
        for (x, y, expected) in [
            (0.625, 0.5, 1.0),
            (0.5, 0.4, 1.0),
            (0.3125, 0.5, 0.0),
            (0.5, 0.75, -1.0),
        ] {
            let got = near(x, y, 0.0);
            assert!((got - expected).abs() < 1e-4, "({x}, {y}): {got}");
        }
        // Itself, on it, and on what stands next to it.
        assert_eq!(near(0.5, 0.5, 0.0), -1.0);
        assert_eq!(near(0.5, 0.5, 0.06), -1.0);
        assert_eq!(near(0.6, 0.5, 0.06), -1.0);
        let broken = [f32::MAX; LOCATION];
        assert_eq!(
            relate(&model, &viewpoint, any, &broken, &at(0.5, 0.5)),
            None
        );
    }

    #[test]
    fn of_two_actions_it_is_the_cosine_to_where_both_put_it() {
        let model = fixture::with_compounds();
        let viewpoint = Viewpoint::new(&model, &fixture::camera());
        let both = model.actions.len() as u8 + 1;
        let related = |x, y| relate(&model, &viewpoint, both, &at(x, y), &at(0.5, 0.5));
        // An eighth to the right, and a sixteenth up.
        let on_the_way = related(0.75, 0.375).unwrap();
        assert!((on_the_way - 1.0).abs() < 1e-4, "{on_the_way}");
        let only_right = related(0.75, 0.5).unwrap();
        assert!((only_right - 0.894_427).abs() < 1e-4, "{only_right}");
        // As each action by itself, and no other index.
        let [one, other] = [1, both + 3]
            .map(|action| relate(&model, &viewpoint, action, &at(0.75, 0.5), &at(0.5, 0.5)));
        assert_eq!(one, right_of_the_middle(0.75, 0.5));
        assert_eq!(other, None);
    }
}
