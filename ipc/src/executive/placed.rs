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

/// What is seen of them. Steps count from 0.
#[derive(Debug, Clone, Copy)]
pub(super) enum Seen {
    /// All are there; how far off the last one is, metres.
    There { off_m: f32 },
    /// This object isn't seen.
    Missing { step: u8, object: u32 },
    /// This is the first step for which something is elsewhere: this object, so far off.
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

    /// Whether all is seen where it was put, and what it was put beside or on where that was.
    pub(super) fn look(&self, map: &PixelToCamera, scene: &Scene, tolerance_m: f32) -> Seen {
        let mut last_off_m = 0.0;
        for (step, placed) in (0..).zip(self.0) {
            let Some(Placed {
                object,
                position,
                reference,
            }) = placed
            else {
                continue;
            };
            let Some(off_m) = distance_m(map, scene, object, &position) else {
                return Seen::Missing { step, object };
            };
            // Neither is one there whose distance is not a number.
            let is_there = off_m <= tolerance_m;
            // One that is hidden by what was put onto it has not been seen to move.
            let reference_off = reference
                .and_then(|(id, at)| Some((id, distance_m(map, scene, id, &at)?)))
                .filter(|(_, off_m)| *off_m > tolerance_m);
            let elsewhere = match reference_off {
                _ if !is_there => Some((object, off_m)),
                off => off,
            };
            if let Some((object, off_m)) = elsewhere {
                return Seen::Elsewhere {
                    step,
                    object,
                    off_m,
                };
            }
            last_off_m = off_m;
        }
        Seen::There { off_m: last_off_m }
    }
}

/// Where an object's centre is seen, world frame, metres; `None` if it isn't seen.
pub(super) fn position(map: &PixelToCamera, scene: &Scene, object: u32) -> Option<[f32; 3]> {
    let seen = scene.objects().iter().find(|seen| seen.id == object)?;
    Some(scene.camera().locate(map, &seen.location).coords.into())
}

/// How far an object is seen from a position; `None` if it isn't seen.
fn distance_m(map: &PixelToCamera, scene: &Scene, object: u32, from: &[f32; 3]) -> Option<f32> {
    let seen = position(map, scene, object)?;
    let offsets = seen.iter().zip(from).map(|(a, b)| a - b);
    Some(offsets.map(|offset| offset * offset).sum::<f32>().sqrt())
}
