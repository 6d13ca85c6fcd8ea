//! The execution of one sentence, from its text to its last step.

use core::task::Poll;
use nsrm_core::language::{Parsed, ParsingTask};
use nsrm_core::planner::PlannedStep;
use nsrm_core::scene::Scene;
use nsrm_core::{MAX_STEPS, Plan, Planner, Refusal};

use super::belief::Belief;
use super::failure::Failure;
use super::limits::Limits;
use super::meant::Meant;
use super::placed::{Deviation, Placements, Steps, Undone};
use super::scene_gate::{AHEAD_NS, SceneGate, too_old};
use super::stage::{CommandStatus, Purpose, Stage, Tried};
use super::view::{Seen, View};
use super::{Command, CommandId, Event, Mode, Sentence};
use crate::message::{Outcome, Report};

/// A sentence being executed. Steps count from 0.
#[derive(Debug)]
pub(super) struct Job<'m> {
    planner: Planner<'m>,
    pub(super) number: u64,
    mode: Mode,
    parsed: Parsed,
    plan: Plan,
    /// The current step: next, or being executed.
    step: usize,
    /// Its plan.
    next: Option<PlannedStep>,
    /// Where the step's reference was observed when it was planned.
    reference: Option<Seen>,
    /// How many commands each step has taken.
    attempts: [u8; MAX_STEPS],
    retries: u8,
    commands: u32,
    /// The objects moved aside for the current command, until they are reported.
    clearing: Option<[u32; 2]>,
    /// Whether any object was moved aside.
    has_cleared: bool,
    placements: Placements,
    belief: Belief,
    meant: Meant,
    /// Why it must end, in any stage.
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
            next: None,
            reference: None,
            attempts: [0; MAX_STEPS],
            retries: 0,
            commands: 0,
            clearing: None,
            has_cleared: false,
            placements: Placements::default(),
            belief: Belief::default(),
            meant: Meant::default(),
            end: None,
            stage: Stage::Parse(ParsingTask::new(planner.model(), sentence)),
        }
    }

    pub(super) fn cancel(&mut self) {
        self.end.get_or_insert(Failure::Cancelled);
    }

    /// Waiting times and the ages of scenes are unknown from now on.
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
                // It was delivered, whatever the sender reported.
                (Outcome::Accepted, CommandStatus::Nothing | CommandStatus::Undelivered) => {
                    *heard = CommandStatus::Accepted;
                    *since_ns = now_ns;
                }
                (
                    Outcome::Clearing,
                    CommandStatus::Nothing | CommandStatus::Undelivered | CommandStatus::Accepted,
                ) => {
                    if !matches!(heard, CommandStatus::Accepted) {
                        *heard = CommandStatus::Accepted;
                        *since_ns = now_ns;
                    }
                    self.clearing = Some(report.objects);
                    self.has_cleared = true;
                    for id in report.objects {
                        self.belief.carry(id);
                    }
                }
                // A repeated or late report extends no timeout and revokes nothing.
                (Outcome::Accepted | Outcome::Clearing, _) => {}
                // The first report counts; it may have been sent before the controller was lost.
                (
                    _,
                    CommandStatus::Nothing
                    | CommandStatus::Accepted
                    | CommandStatus::Lost
                    | CommandStatus::Undelivered,
                ) => {
                    // Not before the command, whatever the controller's clock says: an earlier
                    // scene does not show the result. Nor further in the future than a scene may
                    // be, or no scene would ever be later.
                    let latest_ns = now_ns.saturating_add(AHEAD_NS);
                    let timestamp_ns = report.timestamp_ns.min(latest_ns).max(*sent_ns);
                    *heard = CommandStatus::Ended(Report {
                        timestamp_ns,
                        ..*report
                    });
                }
                (_, CommandStatus::Ended(_)) => {}
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

    pub(super) fn on_controller_lost(&mut self) {
        if let Stage::Commanded { heard, .. } = &mut self.stage
            && matches!(heard, CommandStatus::Nothing | CommandStatus::Accepted)
        {
            *heard = CommandStatus::Lost;
        }
    }

    pub(super) fn on_command_undelivered(&mut self) {
        if let Stage::Commanded { heard, .. } = &mut self.stage
            && matches!(heard, CommandStatus::Nothing)
        {
            *heard = CommandStatus::Undelivered;
        }
    }

    pub(super) fn poll(
        &mut self,
        scene_gate: &mut SceneGate,
        limits: &Limits,
        now_ns: u64,
    ) -> Event {
        self.advance(scene_gate, limits, now_ns)
            .unwrap_or_else(|why| self.give_up(why, now_ns))
    }

    fn advance(
        &mut self,
        scene_gate: &mut SceneGate,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        if let Some(why) = self.end
            && !matches!(self.stage, Stage::Stopping { .. })
        {
            return Err(why);
        }
        match self.stage {
            Stage::Parse(_) => self.parse(now_ns),
            Stage::Look {
                after_ns,
                since_ns,
                purpose,
            } => match scene_gate.look(after_ns, limits, now_ns) {
                Some(scene) => {
                    let model = self.planner.model();
                    let scene = self.belief.complete(&scene, model);
                    let scene = self.meant.only(&scene, self.step, model);
                    match purpose {
                        Purpose::Ground { .. } => self.prepare(scene, since_ns, limits),
                        Purpose::Verify { tried, .. } => {
                            self.verify(scene, tried, (after_ns, since_ns), limits, now_ns)
                        }
                    }
                }
                None if now_ns.saturating_sub(since_ns) <= limits.scene_wait_ns => {
                    Ok(Event::Waiting)
                }
                None => self.look_in_vain(purpose, after_ns, scene_gate, limits, now_ns),
            },
            Stage::Ground { .. } => self.ground(limits, now_ns),
            Stage::Send {
                seen: Some((taken_ns, since_ns)),
            } if too_old(taken_ns, limits, now_ns).is_some() => {
                // The caller was delayed since it was planned.
                self.look_to_ground(taken_ns, since_ns);
                Ok(Event::Working)
            }
            Stage::Send { .. } => self.send(limits, now_ns),
            Stage::Commanded {
                command,
                since_ns,
                heard,
                ..
            } => self.await_outcome(&command, since_ns, heard, limits, now_ns),
            Stage::Stopping {
                since_ns,
                is_lost,
                confirmed,
                begun,
                why,
                ..
            } => {
                // A report of a replacement controller confirms nothing.
                let confirmed = confirmed && !is_lost;
                let waited_ns = now_ns.saturating_sub(since_ns);
                if !confirmed && !is_lost && waited_ns <= limits.accept_wait_ns {
                    return Ok(Event::Waiting);
                }
                Err(stopped(why, confirmed, begun))
            }
            Stage::Finished => Ok(Event::Ended(Ok(()))),
        }
    }

    fn parse(&mut self, now_ns: u64) -> Result<Event, Failure> {
        if let Stage::Parse(task) = &mut self.stage
            && let Poll::Ready(parsed) = task.poll()
        {
            self.parsed = parsed.map_err(Failure::Refused)?.clone();
            self.look_to_ground(0, now_ns);
        }
        Ok(Event::Working)
    }

    fn look(&mut self, after_ns: u64, since_ns: u64, purpose: Purpose) {
        self.stage = Stage::Look {
            after_ns,
            since_ns,
            purpose,
        };
    }

    fn look_to_ground(&mut self, after_ns: u64, since_ns: u64) {
        self.look(after_ns, since_ns, Purpose::Ground { refused: None });
    }

    fn look_to_verify(&mut self, after_ns: u64, since_ns: u64, tried: Tried) {
        let missing = None;
        self.look(after_ns, since_ns, Purpose::Verify { tried, missing });
    }

    /// No scene has arrived, or none that shows the missing object.
    fn look_in_vain(
        &mut self,
        purpose: Purpose,
        after_ns: u64,
        scene_gate: &SceneGate,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        match purpose {
            Purpose::Ground { refused: Some(why) } => Err(why),
            Purpose::Verify {
                tried,
                missing: Some(undone),
            } => {
                let event = self.undo(tried, &undone, limits)?;
                self.look_to_ground(after_ns, now_ns);
                Ok(event)
            }
            Purpose::Verify {
                tried: Tried::Unable(why),
                ..
            } => Err(why),
            Purpose::Ground { .. } | Purpose::Verify { .. } => {
                let last = scene_gate.fault();
                Err(Failure::NoScene { last })
            }
        }
    }

    /// Prepares the next step in a scene: grounds it, unless its object must go back to its old
    /// place.
    fn prepare(&mut self, scene: Scene, since_ns: u64, limits: &Limits) -> Result<Event, Failure> {
        let taken_ns = scene.header().timestamp_ns;
        self.belief.update(&scene);
        if let Some(planned) = self.placements.again(self.step) {
            let (step, object) = (self.step as u8, planned.object.object);
            if self.view(&scene, limits).see(object).is_none() {
                return Err(Failure::NotSeen { step, object });
            }
            self.next = Some(planned);
            self.reference = None;
            let seen = Some((taken_ns, since_ns));
            self.stage = Stage::Send { seen };
            return Ok(Event::Working);
        }
        let parsed = self.parsed.clone();
        let task = self.planner.begin_grounding(scene, parsed, self.step);
        self.stage = Stage::Ground {
            task,
            taken_ns,
            since_ns,
        };
        Ok(Event::Working)
    }

    fn view<'v>(&'v self, scene: &'v Scene, limits: &'v Limits) -> View<'v> {
        View {
            map: self.planner.model().camera,
            scene,
            before: &self.belief,
            limits,
        }
    }

    fn ground(&mut self, limits: &Limits, now_ns: u64) -> Result<Event, Failure> {
        let Stage::Ground {
            task,
            taken_ns,
            since_ns,
        } = &mut self.stage
        else {
            return Ok(Event::Working);
        };
        let Poll::Ready(plan) = task.poll() else {
            return Ok(Event::Working);
        };
        let (taken_ns, since_ns) = (*taken_ns, *since_ns);
        let scene = *task.scene();
        match plan {
            Ok(plan) => {
                self.meant.update(&plan, &scene);
                self.plan = plan;
            }
            // A moving object may still be in the camera's view.
            Err(refusal @ Refusal::Calibration(_)) if self.commands > 0 => {
                let refused = Some(Failure::Refused(refusal));
                self.look(taken_ns, since_ns, Purpose::Ground { refused });
                return Ok(Event::Working);
            }
            Err(refusal) => return Err(Failure::Refused(refusal)),
        }
        self.next = self.plan.steps().first().copied();
        self.reference = self
            .next
            .and_then(|next| self.view(&scene, limits).see(next.reference.object));
        if too_old(taken_ns, limits, now_ns).is_some() {
            // Too old by now: grounding takes time.
            self.look_to_ground(taken_ns, since_ns);
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

    fn send(&mut self, limits: &Limits, now_ns: u64) -> Result<Event, Failure> {
        // A plan has a step for each remaining one, of which there is at least one.
        let planned = self.next.ok_or(Failure::Refused(Refusal::InvalidModel))?;
        self.commands = self.commands.saturating_add(1);
        if let Some(attempts) = self.attempts.get_mut(self.step) {
            *attempts = attempts.saturating_add(1);
        }
        (self.clearing, self.has_cleared) = (None, false);
        self.belief.carry(planned.object.object);
        self.placements.take(self.step, planned.object.object);
        let command = Command {
            id: CommandId {
                plan: self.number,
                command: self.commands,
            },
            until_ns: now_ns.saturating_add(limits.accept_wait_ns),
            // Both are at most MAX_STEPS.
            step: self.step as u8,
            steps: self.steps() as u8,
            planned,
            keep: self.placements.kept(),
        };
        self.stage = Stage::Commanded {
            command,
            sent_ns: now_ns,
            since_ns: now_ns,
            heard: CommandStatus::Nothing,
        };
        Ok(Event::Command(command))
    }

    fn steps(&self) -> usize {
        self.parsed.program().steps().len()
    }

    /// Waits for the outcome of a command.
    fn await_outcome(
        &mut self,
        command: &Command,
        since_ns: u64,
        heard: CommandStatus,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
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
            CommandStatus::Nothing if waited_ns > limits.accept_wait_ns => {
                Err(Failure::NotAccepted { step })
            }
            CommandStatus::Accepted if waited_ns > limits.move_wait_ns => {
                Err(Failure::NoOutcome { step })
            }
            CommandStatus::Nothing | CommandStatus::Accepted => Ok(Event::Waiting),
            CommandStatus::Lost => Err(Failure::ControllerLost { step }),
            CommandStatus::Undelivered => Err(Failure::NotAccepted { step }),
            CommandStatus::Ended(report) => self.end_command(command, &report, limits, now_ns),
        }
    }

    /// The controller reported the outcome of a command.
    fn end_command(
        &mut self,
        command: &Command,
        report: &Report,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        let (step, at_ns, outcome) = (command.step, report.timestamp_ns, report.outcome);
        if outcome == Outcome::Reached {
            return self.end_reached(command, at_ns, now_ns);
        }
        let failure = Failure::Unsuccessful {
            step,
            outcome,
            objects: report.objects,
        };
        let is_closed = self.mode == Mode::ClosedLoop;
        if is_closed && outcome.may_be_tried_again() {
            let event = self.again(self.only(self.step), failure, limits)?;
            self.look_to_verify(at_ns, now_ns, Tried::Known);
            return Ok(event);
        }
        if is_closed && outcome.depends_on_others() {
            self.look_to_verify(at_ns, now_ns, Tried::Unable(failure));
            return Ok(Event::Working);
        }
        Err(failure)
    }

    fn end_reached(
        &mut self,
        command: &Command,
        at_ns: u64,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        if self.mode == Mode::OpenLoop {
            self.placements.finish(self.step);
            self.stage = match self.placements.next(self.steps()) {
                Some(next) => {
                    self.step = next;
                    self.next = self.plan.steps().get(next).copied();
                    Stage::Send { seen: None }
                }
                None => Stage::Finished,
            };
            let (step, off_m) = (command.step, f32::NAN);
            return Ok(Event::Reached { step, off_m });
        }
        let (planned, reference) = (command.planned, self.reference);
        self.placements.put(self.step, planned, reference);
        self.look_to_verify(at_ns, now_ns, Tried::Reached);
        Ok(Event::Working)
    }

    /// Verifies the last attempt and the steps before it; undone steps are repeated.
    ///
    /// * `waits`: the earliest time of the scene, and since when it is awaited
    fn verify(
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
    fn undo(&mut self, tried: Tried, undone: &Undone, limits: &Limits) -> Result<Event, Failure> {
        let why = match tried {
            Tried::Unable(why) => why,
            Tried::Reached | Tried::Known => undone.first.into(),
        };
        let event = self.again(undone.steps, why, limits)?;
        self.placements.undo(&undone.steps);
        self.step = self.placements.next(self.steps()).unwrap_or(self.step);
        Ok(event)
    }

    fn only(&self, step: usize) -> Steps {
        core::array::from_fn(|index| index == step)
    }

    /// Uses up one retry; fails if none is left, or if one of these steps has no attempt left.
    fn again(&mut self, steps: Steps, why: Failure, limits: &Limits) -> Result<Event, Failure> {
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

    /// Ends the sentence with a failure. A command that might still be accepted or executed is
    /// stopped first. Nothing else ends a sentence before its last step is done.
    fn give_up(&mut self, why: Failure, now_ns: u64) -> Event {
        let Stage::Commanded {
            command: Command { id, .. },
            heard: heard @ (CommandStatus::Nothing | CommandStatus::Accepted | CommandStatus::Lost),
            ..
        } = self.stage
        else {
            return Event::Ended(Err(why));
        };
        self.stage = Stage::Stopping {
            id,
            since_ns: now_ns,
            is_lost: matches!(heard, CommandStatus::Lost),
            confirmed: false,
            begun: false,
            why,
        };
        Event::Stop(id)
    }
}

/// The failure of a sentence after a stop was sent.
fn stopped(why: Failure, confirmed: bool, begun: bool) -> Failure {
    match why {
        Failure::Cancelled if !confirmed => Failure::CancelledUnconfirmed,
        // It reported late, or may have started without a report.
        Failure::NotAccepted { step } if begun || !confirmed => Failure::Unanswered { step },
        why => why,
    }
}
