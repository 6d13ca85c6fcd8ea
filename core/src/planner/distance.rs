//! Places at the distance that a sentence names, in the direction in which the learned action puts an object.

use core::num::NonZeroU16;

use nalgebra::{Vector2, Vector3};

use crate::model::{LOCATION, Model};
use crate::viewpoint::Viewpoint;

/// Where an object is put that far from its reference: as far from where the action puts it as the distance is
/// from that of the demonstrations.
///
/// * `put`: where the action puts it, in the image of the training's camera
/// * `reference`: where its reference is, in that image, too
/// * `mm`: the distance between their faces
///
/// Not finite if one of them is not, or if they are at the same place.
///
/// Cost: four deprojections and five square roots.
pub(super) fn at_distance(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    put: &[f32; LOCATION],
    reference: &[f32; LOCATION],
    mm: NonZeroU16,
) -> [f32; LOCATION] {
    let farther_m = 1e-3 * (f32::from(mm.get()) - f32::from(model.distances.usual_mm));
    let aside = along(model, viewpoint, put, reference, farther_m);
    viewpoint.shifted(put, aside.x, aside.y)
}

/// Where an object is that is moved so far along the table; as [`at_distance`] otherwise.
///
/// * `put`: where the action puts an object beside it
/// * `own`: where it is
pub(super) fn shifted_by(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    put: &[f32; LOCATION],
    own: &[f32; LOCATION],
    mm: NonZeroU16,
) -> [f32; LOCATION] {
    let aside = along(model, viewpoint, put, own, 1e-3 * f32::from(mm.get()));
    viewpoint.shifted(own, aside.x, aside.y)
}

/// A vector of this length along the table, in the world, from a reference towards where an action puts an object.
fn along(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    put: &[f32; LOCATION],
    reference: &[f32; LOCATION],
    length_m: f32,
) -> Vector2<f32> {
    let camera = viewpoint.training();
    let [place, from] = [put, reference].map(|location| camera.locate(model.camera, location));
    let aside: Vector3<f32> = place - from;
    aside.xy() * (length_m / aside.xy().norm())
}
