//! What the steps so far have put where, and whether it is still observed there.

use nsrm_core::planner::PlannedStep;
use nsrm_core::{MAX_OBJECTS, MAX_STEPS};

use super::failure::Failure;
use super::view::{Seen, View};

const _: () = assert!(
    2 * MAX_STEPS <= MAX_OBJECTS,
    "not all of `kept` would find room"
);

/// Some of a program's steps, by their places.
pub(super) type Steps = [bool; MAX_STEPS];

/// A step that the controller says it has done.
#[derive(Debug, Clone, Copy)]
struct Placed {
    planned: PlannedStep,
    /// Where its object was observed when the step was confirmed; none until then, and once a
    /// later step moves it on.
    object: Option<Seen>,
    /// Where its reference was observed when the step was planned; none once a later step moves
    /// it on.
    reference: Option<Seen>,
}

/// What each step has put where.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Placements {
    placed: [Option<Placed>; MAX_STEPS],
    done: Steps,
}

/// An object that is not as a step has left it. Steps count from 0.
#[derive(Debug, Clone, Copy)]
pub(super) enum Deviation {
    /// It isn't observed.
    Missing { step: u8, object: u32 },
    /// It is observed elsewhere, so far off.
    Elsewhere { step: u8, object: u32, off_m: f32 },
}

impl From<Deviation> for Failure {
    fn from(amiss: Deviation) -> Self {
        match amiss {
            Deviation::Missing { step, object } => Self::NotSeen { step, object },
            Deviation::Elsewhere {
                step,
                object,
                off_m,
            } => Self::NotThere {
                step,
                object,
                off_m,
            },
        }
    }
}

/// What has come undone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Undone {
    /// The steps that have to do with it.
    pub(super) steps: Steps,
    /// What is amiss with the first of them.
    pub(super) first: Deviation,
    /// Whether anything isn't observed; something may hide it for a while.
    pub(super) is_missing: bool,
}

impl Placements {
    /// The first of so many steps that is not done.
    pub(super) fn next(&self, steps: usize) -> Option<usize> {
        self.done.iter().take(steps).position(|done| !done)
    }

    /// A step was done.
    pub(super) fn finish(&mut self, step: usize) {
        if let Some(done) = self.done.get_mut(step) {
            *done = true;
        }
    }

    /// This step moves an object on: what earlier steps have to do with it is no longer looked at,
    /// whatever comes of it.
    pub(super) fn take(&mut self, step: usize, object: u32) {
        for earlier in self.placed.iter_mut().take(step).flatten() {
            if earlier.planned.object.object == object {
                earlier.object = None;
                earlier.reference = None;
            }
            if earlier.planned.reference.object == object {
                earlier.reference = None;
            }
        }
    }

    /// The controller says that it has done this step.
    ///
    /// * `reference`: where that was observed when the step was planned
    pub(super) fn put(&mut self, step: usize, planned: PlannedStep, reference: Option<Seen>) {
        if let Some(place) = self.placed.get_mut(step) {
            *place = Some(Placed {
                planned,
                object: None,
                reference,
            });
        }
    }

    /// Where the object of an undone step goes again if its reference was moved on by a later
    /// step: grounded anew, it would follow.
    pub(super) fn again(&self, step: usize) -> Option<PlannedStep> {
        let placed = self.placed.get(step)?.as_ref()?;
        placed.reference.is_none().then_some(placed.planned)
    }

    /// Whether a step has put its object where it should, and its reference has stayed: how far
    /// off the object is, metres. Where it is observed now it is to stay.
    pub(super) fn confirm(&mut self, step: usize, view: &View<'_>) -> Result<f32, Deviation> {
        // It was put.
        let Some(placed) = self.placed.get_mut(step).and_then(Option::as_mut) else {
            return Ok(0.0);
        };
        let (step, object) = (step as u8, placed.planned.object.object);
        let seen = view
            .see(object)
            .ok_or(Deviation::Missing { step, object })?;
        let goal = placed.planned.sub_goal.pose.translation.vector.into();
        let off_m = seen.off_m(&goal);
        // Neither is one there whose distance is not a number.
        if off_m.is_nan() || off_m > view.limits.tolerance_m {
            return Err(Deviation::Elsewhere {
                step,
                object,
                off_m,
            });
        }
        if let Some(before) = &placed.reference {
            stayed(step, placed.planned.reference.object, before, view)?;
        }
        placed.object = Some(seen);
        // What was put beside or on it since may stay, if it has come back to where it was.
        for later in self.placed.iter_mut().skip(usize::from(step)).flatten() {
            if later.planned.reference.object == object
                && let Some(before) = &mut later.reference
                && seen.is_within(before, view.limits.tolerance_m)
            {
                *before = seen;
            }
        }
        Ok(off_m)
    }

    /// What is no longer as the steps have left it.
    pub(super) fn undone(&self, view: &View<'_>) -> Option<Undone> {
        let mut found: Option<Undone> = None;
        for ((step, placed), done) in (0..).zip(&self.placed).zip(self.done) {
            let Some(placed) = placed.as_ref().filter(|_| done) else {
                continue;
            };
            let planned = &placed.planned;
            for (id, before) in [
                (planned.object.object, &placed.object),
                (planned.reference.object, &placed.reference),
            ] {
                let Some(before) = before else {
                    continue;
                };
                let Err(amiss) = stayed(step, id, before, view) else {
                    continue;
                };
                let undone = found.get_or_insert(Undone {
                    steps: [false; MAX_STEPS],
                    first: amiss,
                    is_missing: false,
                });
                undone.is_missing |= matches!(amiss, Deviation::Missing { .. });
                if let Some(its) = undone.steps.get_mut(usize::from(step)) {
                    *its = true;
                }
            }
        }
        found
    }

    /// Ids of what the steps that are done have put somewhere, and beside or on what; 0 for none.
    pub(super) fn kept(&self) -> [u32; MAX_OBJECTS] {
        let done = self.placed.iter().zip(self.done).filter(|(_, done)| *done);
        let planned = done.filter_map(|(placed, _)| placed.as_ref());
        let ids = planned.flat_map(|it| [it.planned.object.object, it.planned.reference.object]);
        let mut kept = [0; MAX_OBJECTS];
        for id in ids {
            // Two a step, at most.
            if !kept.contains(&id)
                && let Some(place) = kept.iter_mut().find(|place| **place == 0)
            {
                *place = id;
            }
        }
        kept
    }

    /// These steps are to be done again.
    pub(super) fn undo(&mut self, steps: &Steps) {
        for (done, undone) in self.done.iter_mut().zip(steps) {
            *done &= !undone;
        }
    }
}

/// Whether an object is observed where it was before.
fn stayed(step: u8, object: u32, before: &Seen, view: &View<'_>) -> Result<(), Deviation> {
    let now = view
        .see(object)
        .ok_or(Deviation::Missing { step, object })?;
    match view.moved_m(&now, before) {
        None => Ok(()),
        Some(off_m) => Err(Deviation::Elsewhere {
            step,
            object,
            off_m,
        }),
    }
}
