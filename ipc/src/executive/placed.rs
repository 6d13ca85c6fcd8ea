//! What the steps so far have put where, and whether it is still seen there.

use nsrm_core::MAX_STEPS;
use nsrm_core::model::PixelToCamera;
use nsrm_core::scene::Scene;

/// An object where a step has put it. Positions are of centres, world frame, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub(super) object: u32,
    pub(super) position: [f32; 3],
    /// What that is beside or on, and where it was then; unless it was moved since by a step.
    pub(super) reference: Option<(u32, [f32; 3])>,
}

/// What each step so far has put where, as long as no other took it elsewhere.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Placements([Option<Placed>; MAX_STEPS]);

/// The first of them that is not as a step has left it. Steps count from 0.
#[derive(Debug, Clone, Copy)]
pub(super) enum Amiss {
    /// This object isn't seen.
    Missing { step: u8, object: u32 },
    /// This object is seen elsewhere, so far off.
    Elsewhere { step: u8, object: u32, off_m: f32 },
}

impl Placements {
    /// A step has put an object somewhere: no longer where others had put it, or beside
    /// or on which they had put theirs.
    pub(super) fn put(&mut self, step: usize, placed: Placed) {
        for other in &mut self.0 {
            if other.is_some_and(|other| other.object == placed.object) {
                *other = None;
            }
            if let Some(other) = other
                && other.reference.is_some_and(|(id, _)| id == placed.object)
            {
                other.reference = None;
            }
        }
        if let Some(place) = self.0.get_mut(step) {
            *place = Some(placed);
        }
    }

    /// Nothing that this step or a later one has put somewhere counts any more.
    pub(super) fn forget_from(&mut self, step: u8) {
        for later in self.0.iter_mut().skip(step.into()) {
            *later = None;
        }
    }

    /// Whether all is seen where it was put, and what it was put beside or on where that was: how
    /// far off the object of the last step is, metres.
    ///
    /// * `scene`: with what is hidden
    pub(super) fn look(
        &self,
        map: &PixelToCamera,
        scene: &Scene,
        tolerance_m: f32,
    ) -> Result<f32, Amiss> {
        let off_m = |step, object, at: &[f32; 3]| {
            let seen = position(map, scene, object).ok_or(Amiss::Missing { step, object })?;
            let off_m = distance_m(&seen, at);
            // Neither is one there whose distance is not a number.
            if off_m.is_nan() || off_m > tolerance_m {
                return Err(Amiss::Elsewhere {
                    step,
                    object,
                    off_m,
                });
            }
            Ok(off_m)
        };
        let mut last_off_m = 0.0;
        for (step, placed) in (0..).zip(self.0) {
            let Some(placed) = placed else {
                continue;
            };
            last_off_m = off_m(step, placed.object, &placed.position)?;
            if let Some((reference, at)) = placed.reference {
                off_m(step, reference, &at)?;
            }
        }
        Ok(last_off_m)
    }
}

/// Where an object's centre is seen, world frame, metres; `None` if it isn't seen.
pub(super) fn position(map: &PixelToCamera, scene: &Scene, object: u32) -> Option<[f32; 3]> {
    let seen = scene.objects().iter().find(|seen| seen.id == object)?;
    Some(scene.camera().locate(map, &seen.location).coords.into())
}

fn distance_m(one: &[f32; 3], other: &[f32; 3]) -> f32 {
    let offsets = one.iter().zip(other).map(|(a, b)| a - b);
    offsets.map(|offset| offset * offset).sum::<f32>().sqrt()
}
