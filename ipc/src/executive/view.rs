//! Where objects are in a scene, and whether they have moved since an earlier one.

use nsrm_core::model::PixelToCamera;
use nsrm_core::scene::{ObservedObject, Scene};

use super::belief::{Belief, depth_m, shared};
use super::limits::Limits;

/// The share of an object's box, inside the box of a nearer object, from which on it counts as
/// partly covered. With less, its centre is observed with an error of a millimetre or two.
const COVERED_SHARE: f32 = 0.05;

/// Where an object was observed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Its centre: world frame, metres.
    position: [f32; 3],
    /// Another object that covers part of it and has not moved.
    covered_by: Option<u32>,
}

impl Seen {
    /// Its distance from a position, metres.
    pub(super) fn off_m(&self, place: &[f32; 3]) -> f32 {
        let offsets = self.position.iter().zip(place).map(|(a, b)| a - b);
        offsets.map(|offset| offset * offset).sum::<f32>().sqrt()
    }

    /// Whether it is within this distance of where it was before, metres.
    pub(super) fn is_within(&self, before: &Self, most_m: f32) -> bool {
        self.off_m(&before.position) <= most_m
    }
}

/// A scene, and the belief before it.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    /// Maps pixels to the world.
    pub(super) map: &'a PixelToCamera,
    /// The scene, completed with hidden objects.
    pub(super) scene: &'a Scene,
    /// The objects as they stood before, without those that have been moved since.
    pub(super) before: &'a Belief,
    pub(super) limits: &'a Limits,
}

impl View<'_> {
    /// Where an object is; `None` if it isn't observed.
    pub(super) fn see(&self, object: u32) -> Option<Seen> {
        let own = self.find(object)?;
        let covers = |other: &&ObservedObject| {
            other.id != own.id
                && depth_m(other) < depth_m(own)
                && shared(&other.location, &own.location) > COVERED_SHARE
                && self.has_stayed(other.id)
        };
        let covered_by = self.scene.objects().iter().find(covers);
        Some(Seen {
            position: self.locate(own),
            covered_by: covered_by.map(|other| other.id),
        })
    }

    /// How far an object is from where it was before, metres, if it has moved.
    ///
    /// An object that is partly covered by another one, now or then, may only appear to have moved,
    /// unless the other one has moved, too, as one that stands on it does.
    pub(super) fn moved_m(&self, now: &Seen, before: &Seen) -> Option<f32> {
        let off_m = now.off_m(&before.position);
        let was_covered = before
            .covered_by
            .is_some_and(|other| self.has_stayed(other));
        let most_m = if now.covered_by.is_some() || was_covered {
            self.limits.covered_m.max(self.limits.moved_m)
        } else {
            self.limits.moved_m
        };
        (off_m.is_nan() || off_m > most_m).then_some(off_m)
    }

    /// Whether any object that the robot did not move has moved or disappeared.
    pub(super) fn has_changed(&self) -> bool {
        self.before.objects().iter().any(|object| {
            let before = Seen {
                position: self.locate(object),
                covered_by: None,
            };
            let now = self.see(object.id);
            now.is_none_or(|now| self.moved_m(&now, &before).is_some())
        })
    }

    /// Whether an object is where it was before. Objects that have been moved since, or are no
    /// longer visible, are checked separately.
    fn has_stayed(&self, object: u32) -> bool {
        let mut objects = self.before.objects().iter();
        let before = objects.find(|before| before.id == object);
        let Some((before, now)) = before.zip(self.find(object)) else {
            return true;
        };
        let now = Seen {
            position: self.locate(now),
            covered_by: None,
        };
        now.off_m(&self.locate(before)) <= self.limits.moved_m
    }

    fn find(&self, object: u32) -> Option<&ObservedObject> {
        self.scene.objects().iter().find(|seen| seen.id == object)
    }

    /// The camera is the same for all scenes of a sentence.
    fn locate(&self, object: &ObservedObject) -> [f32; 3] {
        let centre = self.scene.camera().locate(self.map, &object.location);
        centre.coords.into()
    }
}
