//! The believed positions of objects that are hidden by objects that the robot has placed.

use heapless::Vec;
use nsrm_core::model::LOCATION;
use nsrm_core::scene::ObservedObject;
use nsrm_core::{MAX_OBJECTS, Model, Scene};

/// The share of an object's last box that must be hidden, or show its visible rest. Of 999 objects
/// that a detector had lost behind others, 98 % were hidden to this degree
/// (docs/decisions/processes.md).
const HIDDEN_SHARE: f32 = 0.6;
/// How much the box of an unmoved object may vary between images, as a share of its size.
const EDGE_SHARE: f32 = 0.1;

/// The objects of the last scene that was used, including those that were hidden in it.
///
/// An object that is no longer visible, or only in part, is believed to be where it was as long as
/// it is hidden by an object that the robot has moved for this sentence, whose own position is
/// verified separately. A block removed from under another one is detected nevertheless, since the
/// upper one falls. Objects that someone else has put in front of a block are no explanation.
#[derive(Debug, Default)]
pub(super) struct Belief {
    /// The nearest to the camera first.
    objects: Vec<ObservedObject, MAX_OBJECTS>,
    /// Ids of the objects that the robot has moved, as many as fit.
    carried: Vec<u32, MAX_OBJECTS>,
}

impl Belief {
    /// The objects as believed, without those that the robot has moved since.
    pub(super) fn objects(&self) -> &[ObservedObject] {
        &self.objects
    }

    /// Replaces the belief by this scene.
    pub(super) fn update(&mut self, scene: &Scene) {
        self.objects.clear();
        // It has as many places as a scene.
        let _ = self.objects.extend_from_slice(scene.objects());
        self.objects
            .sort_unstable_by(|one, other| depth_m(one).total_cmp(&depth_m(other)));
    }

    /// The robot moves this object.
    pub(super) fn carry(&mut self, id: u32) {
        self.objects.retain(|object| object.id != id);
        if !self.carried.contains(&id) {
            let _ = self.carried.push(id);
        }
    }

    /// Adds to a scene the objects that are hidden in it, where they were before. Objects that do
    /// not fit are left out.
    ///
    /// Cost: compares all pairs of objects, and the checks of a scene.
    pub(super) fn complete(&self, scene: &Scene, model: &Model<'_>) -> Scene {
        let mut raw = *scene.raw();
        // Hidden objects hide others behind them in turn.
        for before in &self.objects {
            let (mut seen, mut hidden) = (None, 0.0_f32);
            for object in raw.objects.iter_mut().take(raw.count as usize) {
                if object.id == before.id {
                    seen = Some(object);
                } else if self.carried.contains(&object.id) && depth_m(object) < depth_m(before) {
                    hidden = hidden.max(shared(&object.location, &before.location));
                }
            }
            match seen {
                None if hidden >= HIDDEN_SHARE => _ = raw.push(*before),
                Some(seen) if is_part(&seen.location, &before.location, hidden) => *seen = *before,
                _ => {}
            }
        }
        // The objects are valid and unique.
        Scene::new(raw, model).unwrap_or(*scene)
    }
}

/// Whether the visible part of an object and what hides it lie where the whole object was seen.
///
/// * `hidden`: the hidden share of it
fn is_part(seen: &[f32; LOCATION], before: &[f32; LOCATION], hidden: f32) -> bool {
    hidden > EDGE_SHARE
        && is_within(seen, before)
        && area(seen) / area(before) + hidden >= HIDDEN_SHARE
}

fn is_within(seen: &[f32; LOCATION], before: &[f32; LOCATION]) -> bool {
    let [x1, y1, x2, y2, _] = *before;
    let (width, height) = (EDGE_SHARE * (x2 - x1), EDGE_SHARE * (y2 - y1));
    seen[0] >= x1 - width
        && seen[1] >= y1 - height
        && seen[2] <= x2 + width
        && seen[3] <= y2 + height
}

/// The share of a box, `own`, that lies in another one.
pub(super) fn shared(other: &[f32; LOCATION], own: &[f32; LOCATION]) -> f32 {
    let common = [
        own[0].max(other[0]),
        own[1].max(other[1]),
        own[2].min(other[2]),
        own[3].min(other[3]),
        0.0,
    ];
    area(&common) / area(own)
}

/// The area as a share of the image; 0 for an invalid box.
fn area(&[x1, y1, x2, y2, _]: &[f32; LOCATION]) -> f32 {
    (x2 - x1).max(0.0) * (y2 - y1).max(0.0)
}

/// The distance of an object from the camera.
pub(super) const fn depth_m(object: &ObservedObject) -> f32 {
    object.location[4]
}

#[cfg(test)]
mod tests {
    use super::{is_part, shared};

    const BEFORE: [f32; 5] = [0.4, 0.4, 0.6, 0.6, 1.0];

    #[test]
    fn a_part_and_what_hides_the_rest_make_up_a_block() {
        let strip = [0.4, 0.4, 0.44, 0.6, 1.02];
        let wide = [0.37, 0.4, 0.44, 0.6, 1.02];
        for (seen, hidden, expected) in [
            (strip, 0.8, true),
            (strip, 0.45, true),
            // Something else hides the rest.
            (strip, 0.35, false),
            (wide, 0.8, false),
            // It is completely visible.
            (BEFORE, 0.05, false),
        ] {
            assert_eq!(is_part(&seen, &BEFORE, hidden), expected, "{seen:?}");
        }
    }

    #[test]
    fn a_box_shares_with_another_what_lies_in_it() {
        for (other, expected) in [
            ([0.5, 0.3, 0.9, 0.7, 0.9], 0.5),
            ([0.3, 0.3, 0.7, 0.7, 0.9], 1.0),
            ([0.6, 0.4, 0.8, 0.6, 0.9], 0.0),
            ([0.7, 0.7, 0.8, 0.8, 0.9], 0.0),
        ] {
            let is = shared(&other, &BEFORE);
            assert!((is - expected).abs() < 1e-6, "{other:?}: {is}");
        }
    }
}
