//! After a command: whether its object, and those of earlier steps, are where they should be, and
//! which steps are repeated if not.

use nsrm_core::scene::Scene;

use super::Job;
use crate::executive::Event;
use crate::executive::failure::Failure;
use crate::executive::limits::Limits;
use crate::executive::placed::{Deviation, Steps, Undone};
use crate::executive::stage::{Purpose, Stage, Tried};
use crate::executive::view::View;

impl Job<'_> {
    /// Verifies the last attempt and the steps before it; undone steps are repeated.
    ///
    /// * `waits`: the earliest time of the scene, and since when it is awaited
    pub(super) fn verify(
        &mut self,
        scene: Scene,
        tried: Tried,
        waits: (u64, u64),
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        let (after_ns, since_ns) = waits;
        let view = View {
            map: self.planner.model().camera,
            scene: &scene,
            before: &self.belief,
            limits,
        };
        let undone = match tried {
            Tried::Reached => match self.placements.confirm(self.step, &view) {
                Ok(off_m) => {
                    // At most MAX_STEPS.
                    let step = self.step as u8;
                    self.placements.finish(self.step);
                    self.look_to_verify(after_ns, now_ns, Tried::Known);
                    return Ok(Event::Reached { step, off_m });
                }
                Err(first) => Some(Undone {
                    steps: self.only(self.step),
                    first,
                    is_missing: matches!(first, Deviation::Missing { .. }),
                }),
            },
            Tried::Known | Tried::Unable(_) => self.placements.undone(&view),
        };
        match (undone, tried) {
            (Some(undone), _) if undone.is_missing => {
                // The arm may hide it for a while.
                let missing = Some(undone);
                let taken_ns = scene.header().timestamp_ns;
                self.look(taken_ns, since_ns, Purpose::Verify { tried, missing });
                Ok(Event::Working)
            }
            (Some(undone), _) => {
                let event = self.undo(tried, &undone, limits)?;
                self.look_to_verify(after_ns, since_ns, Tried::Known);
                Ok(event)
            }
            (None, Tried::Unable(why)) => {
                if !self.has_cleared && !view.has_changed() {
                    return Err(why);
                }
                let event = self.again(self.only(self.step), why, limits)?;
                self.look_to_ground(after_ns, since_ns);
                Ok(event)
            }
            (None, _) => match self.placements.next(self.steps()) {
                Some(next) => {
                    self.step = next;
                    self.prepare(scene, since_ns, limits)
                }
                None => {
                    self.stage = Stage::Finished;
                    Ok(Event::Working)
                }
            },
        }
    }

    /// Repeats these steps, and an attempt that was impossible.
    pub(super) fn undo(
        &mut self,
        tried: Tried,
        undone: &Undone,
        limits: &Limits,
    ) -> Result<Event, Failure> {
        let why = match tried {
            Tried::Unable(why) => why,
            Tried::Reached | Tried::Known => undone.first.into(),
        };
        let event = self.again(undone.steps, why, limits)?;
        self.placements.undo(&undone.steps);
        self.step = self.placements.next(self.steps()).unwrap_or(self.step);
        Ok(event)
    }

    pub(super) fn only(&self, step: usize) -> Steps {
        core::array::from_fn(|index| index == step)
    }

    /// Uses up one retry; fails if none is left, or if one of these steps has no attempt left.
    pub(super) fn again(
        &mut self,
        steps: Steps,
        why: Failure,
        limits: &Limits,
    ) -> Result<Event, Failure> {
        let mut attempts = steps.iter().zip(self.attempts);
        let is_over = attempts.any(|(again, attempts)| *again && attempts >= limits.attempts);
        if is_over || self.retries >= limits.retries {
            return Err(why);
        }
        self.retries += 1;
        let first = steps.iter().position(|again| *again);
        // At most MAX_STEPS.
        let step = first.unwrap_or(self.step) as u8;
        Ok(Event::Again { step, why })
    }
}
