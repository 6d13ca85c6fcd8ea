//! A place at the distance that a sentence names: in the direction in which the learned action puts an object,
//! as far from where it puts it as the distance is from that of the demonstrations.

use core::num::NonZeroU16;

use crate::model::{LOCATION, Model};
use crate::viewpoint::Viewpoint;

/// Where an object is put instead, in the image of the training's camera.
///
/// * `put`: where the action puts it
/// * `reference`: where its reference is
/// * `mm`: the distance between their faces
///
/// Both are in that image, too. Not finite if one of them is not, or if they are at the same place.
///
/// Cost: four deprojections and five square roots.
pub(super) fn at_distance(
    model: &Model<'_>,
    viewpoint: &Viewpoint<'_>,
    put: &[f32; LOCATION],
    reference: &[f32; LOCATION],
    mm: NonZeroU16,
) -> [f32; LOCATION] {
    let camera = viewpoint.training();
    let [place, from] = [put, reference].map(|location| camera.locate(model.camera, location));
    let aside = (place - from).xy();
    let farther_m = 1e-3 * (f32::from(mm.get()) - f32::from(model.distances.usual_mm));
    let [x_m, y_m] = (aside * (farther_m / aside.norm())).into();
    viewpoint.shifted(put, x_m, y_m)
}
