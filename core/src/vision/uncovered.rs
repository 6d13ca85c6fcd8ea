//! The part of an object that no nearer one covers.
//!
//! The box around an object that carries another one shows some of that, too, and so does its crop: of
//! such objects, a third seemed to have another colour. What no nearer box overlaps shows the
//! object alone, and its colour. Its size is told by its whole outline.

use super::Detection;
use crate::model::LOCATION;

/// The least share of an object's visible box from which its colour is told, and the greatest one: if no more
/// is covered, the whole crop never told another colour.
const SHARES: (f32, f32) = (0.1, 0.85);

/// The largest part of the box around an object's visible part that was found to be free of nearer objects:
/// corners x1, y1, x2, y2. `None` if nearly all of it is, or too little.
///
/// * `index`: of the object among the detections; `None` for one that isn't there, too
///
/// Cost: a comparison with each other object.
///
/// ```
/// use nsrm_core::vision::{Detection, uncovered};
///
/// let behind = Detection::whole(1, [0.25, 0.5, 0.5, 1.0, 0.9]);
/// let above = Detection::whole(2, [0.25, 0.25, 0.5, 0.625, 0.8]); // and nearer
/// assert_eq!(uncovered(&[behind, above], 0), Some([0.25, 0.625, 0.5, 1.0]));
/// assert_eq!(uncovered(&[behind, above], 1), None);
/// ```
pub fn uncovered(detections: &[Detection], index: usize) -> Option<[f32; 4]> {
    let object = detections.get(index)?;
    let placed = |detection: &Detection| (detection.visible, depth_m(&detection.location));
    let left = left_of(&placed(object), detections.iter().map(placed));
    let (least, greatest) = SHARES;
    let whole = area(&object.visible);
    let is_part = least * whole <= area(&left) && area(&left) <= greatest * whole;
    is_part.then_some(left)
}

/// The largest part of an object's box that was found to be free of nearer ones, and its share in the box.
pub(crate) fn left_of_box(
    object: &[f32; LOCATION],
    others: impl Iterator<Item = [f32; LOCATION]>,
) -> ([f32; 4], f32) {
    let placed = |[x1, y1, x2, y2, depth_m]: [f32; LOCATION]| ([x1, y1, x2, y2], depth_m);
    let own = placed(*object);
    let left = left_of(&own, others.map(placed));
    (left, area(&left) / area(&own.0))
}

/// The largest part of a box that was found to be free of nearer ones.
fn left_of(
    &(whole, depth_m): &([f32; 4], f32),
    boxes: impl Iterator<Item = ([f32; 4], f32)>,
) -> [f32; 4] {
    let nearer = boxes.filter(|(_, other_m)| *other_m < depth_m);
    nearer.fold(whole, |left, (other, _)| without(left, other))
}

const fn depth_m(&[.., depth_m]: &[f32; LOCATION]) -> f32 {
    depth_m
}

/// The largest part of a box, as high or as wide as it, that another one does not overlap.
fn without(whole: [f32; 4], other: [f32; 4]) -> [f32; 4] {
    let [left, top, right, bottom] = whole;
    let [x1, y1, x2, y2] = other;
    if right.min(x2) <= left.max(x1) || bottom.min(y2) <= top.max(y1) {
        return whole;
    }
    let parts = [
        [left, top, right.min(x1), bottom],
        [left.max(x2), top, right, bottom],
        [left, top, right, bottom.min(y1)],
        [left, top.max(y2), right, bottom],
    ];
    let mut largest = [left, top, left, top];
    for part in parts {
        if area(&part) > area(&largest) {
            largest = part;
        }
    }
    largest
}

/// 0 for a box whose corners are out of order.
fn area(&[left, top, right, bottom]: &[f32; 4]) -> f32 {
    (right - left).max(0.0) * (bottom - top).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: [f32; 5] = [0.25, 0.25, 0.75, 0.75, 0.5];

    fn left(others: &[[f32; 5]]) -> Option<[f32; 4]> {
        let each = [WHOLE].into_iter().chain(others.iter().copied());
        let each: std::vec::Vec<_> = (1..)
            .zip(each)
            .map(|(id, at)| Detection::whole(id, at))
            .collect();
        uncovered(&each, 0)
    }

    #[test]
    fn the_largest_free_part_is_left_of_what_nearer_objects_overlap() {
        for (other, expected) in [
            // On each side; across; inside.
            ([0.0, 0.0, 0.375, 1.0, 0.4], [0.375, 0.25, 0.75, 0.75]),
            ([0.625, 0.0, 1.0, 1.0, 0.4], [0.25, 0.25, 0.625, 0.75]),
            ([0.0, 0.0, 1.0, 0.5, 0.4], [0.25, 0.5, 0.75, 0.75]),
            ([0.0, 0.625, 1.0, 1.0, 0.4], [0.25, 0.25, 0.75, 0.625]),
            ([0.0, 0.5, 1.0, 0.625, 0.4], [0.25, 0.25, 0.75, 0.5]),
            ([0.5, 0.5, 0.625, 0.625, 0.4], [0.25, 0.25, 0.5, 0.75]),
        ] {
            assert_eq!(left(&[other]), Some(expected), "{other:?}");
        }
        let both = [[0.0, 0.0, 1.0, 0.5, 0.4], [0.0, 0.0, 0.375, 1.0, 0.3]];
        assert_eq!(left(&both), Some([0.375, 0.5, 0.75, 0.75]));
    }

    #[test]
    fn what_is_nearly_whole_or_hardly_seen_has_no_such_part() {
        for other in [
            [0.0, 0.0, 1.0, 0.3, 0.4],
            // Farther away, as far, beside it, and in front of nearly all of it.
            [0.0, 0.0, 1.0, 0.5, 0.6],
            [0.0, 0.0, 1.0, 0.5, 0.5],
            [0.75, 0.0, 1.0, 1.0, 0.4],
            [0.0, 0.0, 1.0, 0.71, 0.4],
            [0.0, 0.0, 1.0, 1.0, 0.4],
        ] {
            assert_eq!(left(&[other]), None, "{other:?}");
        }
        assert_eq!(left(&[]), None);
        assert_eq!(uncovered(&[], 0), None);
    }
}
