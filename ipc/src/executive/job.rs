//! One sentence on its way: from its words to its last step.

use nsrm_core::language::{Parsed, ParsingTask};
use nsrm_core::scene::Scene;
use nsrm_core::{Plan, Planner, Progress, Refusal};

use super::belief::Belief;
use super::failure::Failure;
use super::limits::Limits;
use super::looking::{AHEAD_NS, Looking, too_old};
use super::placed::{Amiss, Placed, Placements, position};
use super::stage::{Heard, Purpose, Stage};
use super::{Command, CommandId, Event, Mode, Sentence};
use crate::message::{Outcome, Report};

/// A sentence being carried out. Steps count from 0.
#[derive(Debug)]
pub(super) struct Job<'m> {
    planner: Planner<'m>,
    pub(super) number: u64,
    mode: Mode,
    parsed: Parsed,
    plan: Plan,
    /// The step that is next, or on its way.
    step: usize,
    retries: u8,
    commands: u32,
    /// Where the reference of the step that is next was seen when it was planned.
    reference_at: Option<[f32; 3]>,
    /// What is moved first for the command that is carried out, until it is told.
    clearing: Option<[u32; 2]>,
    placed: Placements,
    belief: Belief,
    /// Why it is to end, whatever it is at.
    end: Option<Failure>,
    stage: Stage<'m>,
}

impl<'m> Job<'m> {
    pub(super) fn new(planner: Planner<'m>, number: u64, sentence: Sentence, mode: Mode) -> Self {
        Self {
            planner,
            number,
            mode,
            parsed: Parsed::empty(planner.model()),
            plan: Plan::default(),
            step: 0,
            retries: 0,
            commands: 0,
            reference_at: None,
            clearing: None,
            placed: Placements::default(),
            belief: Belief::default(),
            end: None,
            stage: Stage::Parse(ParsingTask::new(planner.model(), sentence)),
        }
    }

    pub(super) fn cancel(&mut self) {
        self.end.get_or_insert(Failure::Cancelled);
    }

    /// What was waited for since a time, and how old a scene is, can't be told any more.
    pub(super) fn set_back(&mut self, now_ns: u64) {
        self.end.get_or_insert(Failure::ClockSetBack);
        if let Stage::Stopping { since_ns, .. } = &mut self.stage {
            *since_ns = now_ns;
        }
    }

    pub(super) fn hear(&mut self, report: &Report, now_ns: u64) {
        match &mut self.stage {
            Stage::Commanded {
                command,
                sent_ns,
                since_ns,
                heard,
            } if command.id == report.id => match (report.outcome, &heard) {
                // It got there, whatever came of sending it.
                (Outcome::Accepted, Heard::Nothing | Heard::Undelivered) => {
                    *heard = Heard::Accepted;
                    *since_ns = now_ns;
                }
                (Outcome::Clearing, Heard::Nothing | Heard::Undelivered | Heard::Accepted) => {
                    if !matches!(heard, Heard::Accepted) {
                        *heard = Heard::Accepted;
                        *since_ns = now_ns;
                    }
                    self.clearing = Some(report.objects);
                    for id in report.objects {
                        self.belief.carry(id);
                    }
                }
                // Said again, or late, it gives no more time and takes nothing back.
                (Outcome::Accepted | Outcome::Clearing, _) => {}
                // What is said first counts; it may have been on its way when the
                // controller was lost.
                (_, Heard::Nothing | Heard::Accepted | Heard::Lost | Heard::Undelivered) => {
                    // Not before the command, whatever the controller's clock says: a
                    // scene from before it shows nothing of what came of it. Nor farther
                    // ahead than a scene may be, or none would ever be later.
                    let latest_ns = now_ns.saturating_add(AHEAD_NS);
                    let timestamp_ns = report.timestamp_ns.min(latest_ns).max(*sent_ns);
                    *heard = Heard::Ended(Report {
                        timestamp_ns,
                        ..*report
                    });
                }
                (_, Heard::Ended(_)) => {}
            },
            Stage::Stopping {
                id,
                confirmed,
                begun,
                ..
            } if *id == report.id => {
                *begun |= matches!(
                    report.outcome,
                    Outcome::Accepted | Outcome::Clearing | Outcome::Reached
                );
                *confirmed |= report.outcome.is_end();
            }
            _ => {}
        }
    }

    pub(super) fn lose_controller(&mut self) {
        if let Stage::Commanded { heard, .. } = &mut self.stage
            && matches!(heard, Heard::Nothing | Heard::Accepted)
        {
            *heard = Heard::Lost;
        }
    }

    pub(super) fn miss_controller(&mut self) {
        if let Stage::Commanded { heard, .. } = &mut self.stage
            && matches!(heard, Heard::Nothing)
        {
            *heard = Heard::Undelivered;
        }
    }

    pub(super) fn poll(&mut self, looking: &mut Looking, limits: &Limits, now_ns: u64) -> Event {
        self.advance(looking, limits, now_ns)
            .unwrap_or_else(|why| self.give_up(why, now_ns))
    }

    fn advance(
        &mut self,
        looking: &mut Looking,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        if let Some(why) = self.end
            && !matches!(self.stage, Stage::Stopping { .. })
        {
            return Err(why);
        }
        match &mut self.stage {
            Stage::Parse(task) => {
                let Progress::Done(parsed) = task.poll() else {
                    return Ok(Event::Working);
                };
                self.parsed = parsed.map_err(Failure::Refused)?.clone();
                self.look(0, now_ns, Purpose::Ground);
                Ok(Event::Working)
            }
            &mut Stage::Look {
                after_ns,
                since_ns,
                purpose,
            } => {
                if let Some(scene) = looking.look(after_ns, limits, now_ns) {
                    let scene = self.belief.complete(&scene, self.planner.model());
                    return match purpose {
                        Purpose::Ground => Ok(self.ground(scene, since_ns)),
                        Purpose::Verify { .. } => self.verify(&scene, after_ns, since_ns, limits),
                    };
                }
                if now_ns.saturating_sub(since_ns) <= limits.scene_wait_ns {
                    return Ok(Event::Waiting);
                }
                let Purpose::Verify {
                    missing: Some((step, object)),
                } = purpose
                else {
                    let last = looking.fault();
                    return Err(Failure::NoScene { last });
                };
                let event = self.again(Failure::NotSeen { step, object }, limits)?;
                self.go_back(step);
                self.look(after_ns, now_ns, Purpose::Ground);
                Ok(event)
            }
            &mut Stage::Ground {
                ref mut task,
                taken_ns,
                since_ns,
            } => {
                let Progress::Done(plan) = task.poll() else {
                    return Ok(Event::Working);
                };
                self.plan = plan.map_err(Failure::Refused)?;
                let (map, scene) = (self.planner.model().camera, task.scene());
                let reference = self.plan.steps().first().map(|next| next.reference.object);
                self.reference_at = reference.and_then(|it| position(map, scene, it));
                if too_old(taken_ns, limits, now_ns).is_some() {
                    // By now: grounding took its time.
                    self.look(taken_ns, since_ns, Purpose::Ground);
                    return Ok(Event::Working);
                }
                self.stage = match self.mode {
                    Mode::PlanOnly => Stage::Finished,
                    Mode::ClosedLoop | Mode::OpenLoop => Stage::Send {
                        seen: Some((taken_ns, since_ns)),
                    },
                };
                Ok(Event::Planned(self.plan.clone()))
            }
            &mut Stage::Send {
                seen: Some((taken_ns, since_ns)),
            } if too_old(taken_ns, limits, now_ns).is_some() => {
                // Who polls was held up since it was planned.
                self.look(taken_ns, since_ns, Purpose::Ground);
                Ok(Event::Working)
            }
            Stage::Send { .. } => self.send(limits, now_ns),
            &mut Stage::Commanded {
                command,
                since_ns,
                heard,
                ..
            } => {
                let (step, waited_ns) = (command.step, now_ns.saturating_sub(since_ns));
                if let Some(first) = self.clearing.take() {
                    let object = command.planned.object.object;
                    return Ok(Event::Clearing {
                        step,
                        object,
                        first,
                    });
                }
                match heard {
                    Heard::Nothing if waited_ns > limits.accept_wait_ns => {
                        Err(Failure::NotAccepted { step })
                    }
                    Heard::Accepted if waited_ns > limits.move_wait_ns => {
                        Err(Failure::NoOutcome { step })
                    }
                    Heard::Nothing | Heard::Accepted => Ok(Event::Waiting),
                    Heard::Lost => Err(Failure::ControllerLost { step }),
                    Heard::Undelivered => Err(Failure::NotAccepted { step }),
                    Heard::Ended(report) => self.end_command(&command, &report, limits, now_ns),
                }
            }
            &mut Stage::Stopping {
                since_ns,
                is_lost,
                confirmed,
                begun,
                why,
                ..
            } => {
                let waited_ns = now_ns.saturating_sub(since_ns);
                // What another one says that was started in its place confirms nothing.
                let confirmed = confirmed && !is_lost;
                if !confirmed && !is_lost && waited_ns <= limits.accept_wait_ns {
                    return Ok(Event::Waiting);
                }
                Err(match why {
                    Failure::Cancelled if !confirmed => Failure::CancelledUnconfirmed,
                    // It says so late, or may have begun without being heard.
                    Failure::NotAccepted { step } if begun || !confirmed => {
                        Failure::Unanswered { step }
                    }
                    why => why,
                })
            }
            Stage::Finished => Ok(Event::Ended(Ok(()))),
        }
    }

    fn look(&mut self, after_ns: u64, since_ns: u64, purpose: Purpose) {
        self.stage = Stage::Look {
            after_ns,
            since_ns,
            purpose,
        };
    }

    fn ground(&mut self, scene: Scene, since_ns: u64) -> Event {
        let taken_ns = scene.header().timestamp_ns;
        self.belief.update(&scene);
        let parsed = self.parsed.clone();
        let task = self.planner.begin_grounding(scene, parsed, self.step);
        self.stage = Stage::Ground {
            task,
            taken_ns,
            since_ns,
        };
        Event::Working
    }

    fn send(&mut self, limits: &Limits, now_ns: u64) -> Result<Event, Failure> {
        let place = self.step.saturating_sub(self.plan.first());
        let planned = self.plan.steps().get(place).copied();
        // A plan has a step for each one left, and one was.
        let planned = planned.ok_or(Failure::Refused(Refusal::InvalidModel))?;
        self.commands = self.commands.saturating_add(1);
        self.clearing = None;
        self.belief.carry(planned.object.object);
        let command = Command {
            id: CommandId {
                plan: self.number,
                command: self.commands,
            },
            until_ns: now_ns.saturating_add(limits.accept_wait_ns),
            // At most MAX_STEPS, both.
            step: self.step as u8,
            steps: self.steps() as u8,
            planned,
        };
        self.stage = Stage::Commanded {
            command,
            sent_ns: now_ns,
            since_ns: now_ns,
            heard: Heard::Nothing,
        };
        Ok(Event::Command(command))
    }

    fn steps(&self) -> usize {
        self.parsed.program().steps().len()
    }

    /// The controller says how a command went.
    fn end_command(
        &mut self,
        command: &Command,
        report: &Report,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        let (step, at_ns) = (command.step, report.timestamp_ns);
        if report.outcome != Outcome::Reached {
            let failure = Failure::Unsuccessful {
                step,
                outcome: report.outcome,
                objects: report.objects,
            };
            if self.mode == Mode::OpenLoop || !report.outcome.may_be_tried_again() {
                return Err(failure);
            }
            let event = self.again(failure, limits)?;
            self.look(at_ns, now_ns, Purpose::Ground);
            return Ok(event);
        }
        let sub_goal = &command.planned.sub_goal;
        let reference = command.planned.reference.object;
        let placed = Placed {
            object: sub_goal.object,
            position: sub_goal.pose.translation.vector.into(),
            reference: self.reference_at.map(|at| (reference, at)),
        };
        self.placed.put(self.step, placed);
        if self.mode == Mode::OpenLoop {
            self.advance_step(Stage::Send { seen: None });
            let off_m = f32::NAN;
            return Ok(Event::Reached { step, off_m });
        }
        self.look(at_ns, now_ns, Purpose::Verify { missing: None });
        Ok(Event::Working)
    }

    /// Whether the steps so far have done what they should; if not, goes back to the first
    /// for which that isn't so.
    fn verify(
        &mut self,
        scene: &Scene,
        after_ns: u64,
        since_ns: u64,
        limits: &Limits,
    ) -> Result<Event, Failure> {
        let map = self.planner.model().camera;
        match self.placed.look(map, scene, limits.tolerance_m) {
            Err(Amiss::Missing { step, object }) => {
                // An arm may hide it for a while.
                let missing = Some((step, object));
                let taken_ns = scene.header().timestamp_ns;
                self.look(taken_ns, since_ns, Purpose::Verify { missing });
                Ok(Event::Working)
            }
            Err(Amiss::Elsewhere {
                step,
                object,
                off_m,
            }) => {
                let failure = Failure::NotThere {
                    step,
                    object,
                    off_m,
                };
                let event = self.again(failure, limits)?;
                self.go_back(step);
                self.look(after_ns, since_ns, Purpose::Ground);
                Ok(event)
            }
            Ok(off_m) => {
                // At most MAX_STEPS.
                let step = self.step as u8;
                self.advance_step(Stage::Look {
                    after_ns,
                    since_ns,
                    purpose: Purpose::Ground,
                });
                Ok(Event::Reached { step, off_m })
            }
        }
    }

    /// This step, and those after it, are to be done again.
    fn go_back(&mut self, step: u8) {
        self.placed.forget_from(step);
        self.step = step.into();
    }

    /// The step is done; this comes next, unless it was the last.
    fn advance_step(&mut self, next: Stage<'m>) {
        self.step = self.step.saturating_add(1);
        self.stage = if self.step < self.steps() {
            next
        } else {
            Stage::Finished
        };
    }

    /// One retry less; the failure when none is left.
    fn again(&mut self, why: Failure, limits: &Limits) -> Result<Event, Failure> {
        if self.retries >= limits.retries {
            return Err(why);
        }
        self.retries += 1;
        // At most MAX_STEPS.
        let step = self.step as u8;
        Ok(Event::Again { step, why })
    }

    /// Ends so. Whatever it fails with, a command that may still be accepted or carried out is
    /// stopped first: nothing else ends a sentence before its last step is done.
    fn give_up(&mut self, why: Failure, now_ns: u64) -> Event {
        let Stage::Commanded {
            command: Command { id, .. },
            heard: heard @ (Heard::Nothing | Heard::Accepted | Heard::Lost),
            ..
        } = self.stage
        else {
            return Event::Ended(Err(why));
        };
        self.stage = Stage::Stopping {
            id,
            since_ns: now_ns,
            is_lost: matches!(heard, Heard::Lost),
            confirmed: false,
            begun: false,
            why,
        };
        Event::Stop(id)
    }
}
