//! Where a scene shows objects, and whether they have moved since another one.

use nsrm_core::model::PixelToCamera;
use nsrm_core::scene::{ObservedObject, Scene};

use super::belief::{Belief, depth_m, shared};
use super::limits::Limits;

/// An object is covered in part if so much of its box lies in that of a nearer one: with less, its
/// centre is observed within a millimetre or two of where it would be.
const COVERED_SHARE: f32 = 0.05;

/// Where an object was observed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Of its centre, world frame, metres.
    position: [f32; 3],
    /// Another that covers a part of it, and has stayed where it was.
    covered_by: Option<u32>,
}

impl Seen {
    /// How far it is from a place, metres.
    pub(super) fn off_m(&self, place: &[f32; 3]) -> f32 {
        let offsets = self.position.iter().zip(place).map(|(a, b)| a - b);
        offsets.map(|offset| offset * offset).sum::<f32>().sqrt()
    }

    /// Whether it is so near to where it was before, metres.
    pub(super) fn is_within(&self, before: &Self, most_m: f32) -> bool {
        self.off_m(&before.position) <= most_m
    }
}

/// A scene, and what was believed before it.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    /// From pixels to the world.
    pub(super) map: &'a PixelToCamera,
    /// With what is hidden in it.
    pub(super) scene: &'a Scene,
    /// How all stood before, but for what was carried since.
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
    /// One that another covers in part, now or then, may seem to: unless that has moved, too, as
    /// what stands on it does.
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

    /// Whether anything that was not carried is elsewhere than before, or gone.
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

    /// Whether an object is where it was before. What was carried since is looked at for itself, as
    /// is what is no longer observed.
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
