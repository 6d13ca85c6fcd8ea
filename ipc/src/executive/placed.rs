//! Where the steps so far have placed objects, and whether they are still observed there.

use nsrm_core::planner::PlannedStep;
use nsrm_core::{MAX_OBJECTS, MAX_STEPS};

use super::failure::Failure;
use super::view::{Seen, View};

const _: () = assert!(
    2 * MAX_STEPS <= MAX_OBJECTS,
    "not all of `kept` would find room"
);

/// A set of a program's steps, by number.
pub(super) type Steps = [bool; MAX_STEPS];

/// A step that the controller reported as done.
#[derive(Debug, Clone, Copy)]
struct Placed {
    planned: PlannedStep,
    /// Where its object was observed when the step was confirmed; `None` before that, and after a
    /// later step moves it.
    object: Option<Seen>,
    /// Where its reference was observed when the step was planned; `None` after a later step moves
    /// it.
    reference: Option<Seen>,
}

/// Where each step has placed its object.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Placements {
    placed: [Option<Placed>; MAX_STEPS],
    done: Steps,
}

/// An object that is not where a step has left it. Steps count from 0.
#[derive(Debug, Clone, Copy)]
pub(super) enum Deviation {
    /// It is not visible.
    Missing { step: u8, object: u32 },
    /// It is observed elsewhere, at this distance.
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

/// Steps that are undone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Undone {
    /// The affected steps.
    pub(super) steps: Steps,
    /// What is wrong with the first of them.
    pub(super) first: Deviation,
    /// Whether an object is not visible; it may be hidden for a while.
    pub(super) is_missing: bool,
}

impl Placements {
    /// The first of `steps` steps that is not done.
    pub(super) fn next(&self, steps: usize) -> Option<usize> {
        self.done.iter().take(steps).position(|done| !done)
    }

    /// A step was done.
    pub(super) fn finish(&mut self, step: usize) {
        if let Some(done) = self.done.get_mut(step) {
            *done = true;
        }
    }

    /// This step moves an object of earlier steps, which are no longer verified for it, whatever
    /// the outcome.
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

    /// The controller reported that this step is done.
    ///
    /// * `reference`: where the reference was observed when the step was planned
    pub(super) fn put(&mut self, step: usize, planned: PlannedStep, reference: Option<Seen>) {
        if let Some(place) = self.placed.get_mut(step) {
            *place = Some(Placed {
                planned,
                object: None,
                reference,
            });
        }
    }

    /// The old sub-goal for the object of a step whose reference was moved by a later one, or which moves it from
    /// where it was: grounded again, the object would follow its reference, or move on.
    pub(super) fn again(&self, step: usize) -> Option<PlannedStep> {
        let placed = self.placed.get(step)?.as_ref()?;
        placed.reference.is_none().then_some(placed.planned)
    }

    /// Whether a step has placed its object at its sub-goal and its reference has not moved;
    /// returns the object's distance, metres. From now on it must stay where it is observed.
    pub(super) fn confirm(&mut self, step: usize, view: &View<'_>) -> Result<f32, Deviation> {
        // It has been placed.
        let Some(placed) = self.placed.get_mut(step).and_then(Option::as_mut) else {
            return Ok(0.0);
        };
        let (step, object) = (step as u8, placed.planned.object.object);
        let seen = view
            .see(object)
            .ok_or(Deviation::Missing { step, object })?;
        let goal = placed.planned.sub_goal.pose.translation.vector.into();
        let off_m = seen.off_m(&goal);
        // A distance that is NaN counts as elsewhere.
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
        // Later steps that used it as a reference remain valid if it is back where it was.
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

    /// The objects that are no longer where the steps have left them.
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

    /// Ids of the objects and references of completed steps; 0 for none.
    pub(super) fn kept(&self) -> [u32; MAX_OBJECTS] {
        let done = self.placed.iter().zip(self.done).filter(|(_, done)| *done);
        let planned = done.filter_map(|(placed, _)| placed.as_ref());
        let ids = planned.flat_map(|it| [it.planned.object.object, it.planned.reference.object]);
        let mut kept = [0; MAX_OBJECTS];
        for id in ids {
            // At most two per step.
            if !kept.contains(&id)
                && let Some(place) = kept.iter_mut().find(|place| **place == 0)
            {
                *place = id;
            }
        }
        kept
    }

    /// Marks these steps as not done.
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
