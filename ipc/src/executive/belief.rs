//! Where objects are believed to be that are hidden by what the robot has put down.

use heapless::Vec;
use nsrm_core::model::LOCATION;
use nsrm_core::scene::ObservedObject;
use nsrm_core::{MAX_OBJECTS, Model, Scene};

/// Of the box in which an object was seen, so much at least is hidden, or shows what is still
/// seen of it. Of 999 objects that a detector had lost behind others, 98 % were hidden so far
/// (docs/decisions/processes.md).
const HIDDEN_SHARE: f32 = 0.6;
/// By so much of its size the box of an object that stays may differ from picture to picture.
const EDGE_SHARE: f32 = 0.1;

/// The objects of the scene that was acted upon last, those included that were hidden in it.
///
/// One of them that is no longer seen, or only in part, is believed to be as it was as long as
/// something hides it that the robot has carried for this sentence: that this stands where it
/// was put is looked at besides. A block that has vanished from under another is missed all the
/// same, since that has fallen. What someone else has put before a block excuses nothing.
#[derive(Debug, Default)]
pub(super) struct Belief {
    /// The nearest to the camera first.
    objects: Vec<ObservedObject, MAX_OBJECTS>,
    /// Ids of what the robot has carried; of more than that it is not known.
    carried: Vec<u32, MAX_OBJECTS>,
}

impl Belief {
    /// As they were believed to be; without what the robot has carried since.
    pub(super) fn objects(&self) -> &[ObservedObject] {
        &self.objects
    }

    /// This is how things stand now.
    pub(super) fn update(&mut self, scene: &Scene) {
        self.objects.clear();
        // As many places as a scene has.
        let _ = self.objects.extend_from_slice(scene.objects());
        self.objects
            .sort_unstable_by(|one, other| depth_m(one).total_cmp(&depth_m(other)));
    }

    /// The robot takes this object elsewhere.
    pub(super) fn carry(&mut self, id: u32) {
        self.objects.retain(|object| object.id != id);
        if !self.carried.contains(&id) {
            let _ = self.carried.push(id);
        }
    }

    /// A scene with what is hidden in it as it was before. What finds no room is left out.
    ///
    /// Cost: each object is compared with each other one, and the checks of a scene.
    pub(super) fn complete(&self, scene: &Scene, model: &Model<'_>) -> Scene {
        let mut raw = *scene.raw();
        // What is hidden hides what is behind it, in turn.
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
        // Of sound objects, each of which it has once.
        Scene::new(raw, model).unwrap_or(*scene)
    }
}

/// Whether what is seen of an object, and what hides it, are where all of it was seen.
///
/// * `hidden`: the share of it that is hidden
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

/// How much of a box, `own`, lies in another one.
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

/// As a share of the image; of a box that is none, 0.
fn area(&[x1, y1, x2, y2, _]: &[f32; LOCATION]) -> f32 {
    (x2 - x1).max(0.0) * (y2 - y1).max(0.0)
}

/// How far from the camera an object is.
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
            // Something else keeps the rest from being seen.
            (strip, 0.35, false),
            (wide, 0.8, false),
            // All of it is seen.
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
