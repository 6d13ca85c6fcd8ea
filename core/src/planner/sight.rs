//! What is seen in part only, and what can be told of it all the same: its colour from what is left of it,
//! and its size from how wide that is.

use nalgebra::Point3;

use super::resolve::Within;
use crate::calibration::{APART_PX, sizes, widths_m};
use crate::model::{LOCATION, Model};
use crate::vision::left_of_box;

/// Share of an object's box above which a nearer one would hide what it looks like.
pub(super) const HIDDEN: f32 = 0.2;
/// How near the box of another object is, in widths and heights of its own, if it may hide a part of it or
/// stand on it: there, the boxes of their visible parts touch.
const NEAR: f32 = 0.25;
/// The least share of an object's box that nearer ones leave, if its colour is told from the rest: of 1,375
/// objects with less than all and more than that, none misses its colour.
const COLOR_TOLD: f32 = 0.25;
/// How far apart the centres of two objects are at most along the table if one stands on the other, and
/// how much higher that one is at least, metres: half an edge of the paper's larger blocks, farther out
/// nothing rests, and half of what its smaller blocks are higher by on each other.
pub(super) const ON_TOP_M: (f32, f32) = (0.03, 0.02);

/// How an object of the scene is seen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// In part only: it may seem to have another size or colour.
    pub(super) is_partial: bool,
    /// So little of it that its place is less certain.
    pub(super) is_rough: bool,
    /// Enough of it for its colour.
    pub(super) is_color_told: bool,
    /// How wide it is, at least,
    at_least_m: f32,
    /// and at most: if a side of it may be hidden, it may be wider than it looks. Metres.
    at_most_m: f32,
}

/// Whether an object is as the sentence says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fit {
    Yes,
    /// Others hide what tells.
    Maybe,
    No,
}

impl Sight {
    /// Seen whole.
    pub(super) const WHOLE: Self = Self {
        is_partial: false,
        is_rough: false,
        is_color_told: true,
        at_least_m: 0.0,
        at_most_m: f32::INFINITY,
    };

    /// How an object is seen, in the scene and after the steps so far.
    ///
    /// Cost: a comparison with each other object; if one is near, the places of all, twice.
    pub(super) fn of(index: usize, within: &Within<'_>) -> Self {
        let objects = within.scene.objects();
        let now = within.locations.get(..objects.len()).unwrap_or_default();
        let Some((object, place)) = objects.get(index).zip(now.get(index)) else {
            return Self::WHOLE;
        };
        let seen = objects.iter().map(|object| object.location);
        let now = now.iter().copied();
        let is_alone = !has_neighbour(index, seen.clone());
        if is_alone && !(within.has_moved && has_neighbour(index, now.clone())) {
            return Self::WHOLE;
        }
        let camera = within.scene.camera();
        let (x, y) = (
            APART_PX / camera.width as f32,
            APART_PX / camera.height as f32,
        );
        // The box of what another one hides ends where that begins.
        let around =
            |[x1, y1, x2, y2, depth_m]: [f32; LOCATION]| [x1 - x, y1 - y, x2 + x, y2 + y, depth_m];
        // What earlier steps uncover looks as it did before; what they cover will be seen in part.
        let is_rough = is_hidden(&object.location, seen.clone(), HIDDEN)
            || carries_any(index, now.clone(), within)
            || (within.has_moved && {
                let before = seen.clone();
                let before = before.map(|location| within.viewpoint.to_training(&location));
                is_hidden(place, now, HIDDEN) || carries_any(index, before, within)
            });
        let is_partial = is_rough || is_hidden(&object.location, seen.clone().map(around), 0.0);
        let (left, share) = left_of_box(&object.location, seen.map(around));
        let width_m = camera.width_m(&object.location);
        let ([x1, _, x2, _, _], [left_x1, _, left_x2, _]) = (object.location, left);
        let shows_both_sides = left_x1 <= x1 && left_x2 >= x2;
        Self {
            is_partial,
            is_rough,
            is_color_told: share >= COLOR_TOLD,
            at_least_m: width_m,
            at_most_m: if shows_both_sides {
                width_m
            } else {
                f32::INFINITY
            },
        }
    }

    /// Whether an object that is seen in part has a size, by its width.
    pub(super) fn has_size(&self, size: u8, model: &Model<'_>) -> Fit {
        let (mut may_have_it, mut may_have_another) = (false, false);
        for (index, concept) in model.concepts.iter().enumerate() {
            if concept.edges_m.is_some_and(|edges_m| self.may_be(edges_m)) {
                let is_it = index == usize::from(size);
                may_have_it |= is_it;
                may_have_another |= !is_it;
            }
        }
        match (may_have_it, may_have_another) {
            (false, _) => Fit::No,
            (true, false) => Fit::Yes,
            (true, true) => Fit::Maybe,
        }
    }

    /// The volume of an object that is seen in part, by its width, cubic metres; NaN if it may have several
    /// sizes.
    pub(super) fn volume(&self, model: &Model<'_>) -> f32 {
        let mut volumes = sizes(model)
            .filter(|edges_m| self.may_be(*edges_m))
            .map(|edges_m| edges_m.iter().product());
        match (volumes.next(), volumes.next()) {
            (Some(volume), None) => volume,
            _ => f32::NAN,
        }
    }

    fn may_be(&self, edges_m: [f32; 3]) -> bool {
        let (least_m, greatest_m) = widths_m(edges_m);
        self.at_least_m <= greatest_m && least_m <= self.at_most_m
    }
}

/// Whether a nearer object overlaps more than this share of its box.
pub(super) fn is_hidden(
    object: &[f32; LOCATION],
    objects: impl Iterator<Item = [f32; LOCATION]>,
    share: f32,
) -> bool {
    let [left, top, right, bottom, depth_m] = *object;
    let hidden = share * (right - left) * (bottom - top);
    let mut nearer = objects.filter(|[.., other_m]| *other_m < depth_m);
    nearer.any(|other| overlap(object, &other) > hidden)
}

/// Whether another object's box is so near that it may hide a part of this one or stand on it.
fn has_neighbour(index: usize, locations: impl Iterator<Item = [f32; LOCATION]> + Clone) -> bool {
    let Some([x1, y1, x2, y2, depth_m]) = locations.clone().nth(index) else {
        return false;
    };
    let (x, y) = (NEAR * (x2 - x1), NEAR * (y2 - y1));
    let around = [x1 - x, y1 - y, x2 + x, y2 + y, depth_m];
    let mut others = locations.enumerate().filter(|(other, _)| *other != index);
    others.any(|(_, other)| overlap(&around, &other) > 0.0)
}

/// How much of the image two boxes share.
fn overlap(one: &[f32; LOCATION], other: &[f32; LOCATION]) -> f32 {
    let ([left, top, right, bottom, _], [x1, y1, x2, y2, _]) = (*one, *other);
    let width = right.min(x2) - left.max(x1);
    let height = bottom.min(y2) - top.max(y1);
    width.max(0.0) * height.max(0.0)
}

/// Whether another object stands on it, which then covers its upper face.
fn carries_any(
    index: usize,
    locations: impl Iterator<Item = [f32; LOCATION]> + Clone,
    within: &Within<'_>,
) -> bool {
    let mut places = locations.map(|location| within.place(&location));
    let Some(place) = places.clone().nth(index) else {
        return false;
    };
    let (aside_m, higher_m) = ON_TOP_M;
    places.any(|other: Point3<f32>| {
        let [x, y, z]: [f32; 3] = (other - place).into();
        z > higher_m && x * x + y * y < aside_m * aside_m
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_nearer_object_overlaps_is_hidden() {
        let object = [0.4, 0.4, 0.5, 0.6, 0.5];
        // Overlapping by 0.05 of 0.1 and by 0.1 of 0.2: a quarter.
        let over = [0.45, 0.5, 0.6, 0.7, 0.4];
        assert!(is_hidden(&object, [object, over].into_iter(), HIDDEN));
        let behind = [0.45, 0.5, 0.6, 0.7, 0.6];
        let less = [0.47, 0.5, 0.6, 0.7, 0.4];
        let beside = [0.5, 0.4, 0.6, 0.6, 0.4];
        let apart = [0.6, 0.7, 0.7, 0.9, 0.4];
        let others = [object, behind, less, beside, apart];
        assert!(!is_hidden(&object, others.into_iter(), HIDDEN));
        assert!(is_hidden(&object, others.into_iter(), 0.0));
    }
}
