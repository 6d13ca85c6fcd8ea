//! The execution of one sentence, from its text to its last step.
//!
//! Here is the order of its stages, and how a step is planned; `command` has what the controller
//! is told and reports, `verify` what the camera shows of it afterwards.

mod command;
mod verify;

use core::task::Poll;
use nsrm_core::language::{Parsed, ParsingTask};
use nsrm_core::planner::PlannedStep;
use nsrm_core::scene::Scene;
use nsrm_core::{MAX_STEPS, Plan, Planner, Refusal};

use super::belief::Belief;
use super::failure::Failure;
use super::limits::Limits;
use super::meant::Meant;
use super::placed::Placements;
use super::scene_gate::{SceneGate, too_old};
use super::stage::{Purpose, Stage, Tried};
use super::view::{Seen, View};
use super::{Event, Mode, Sentence};
use command::stopped;

/// A sentence being executed. Steps count from 0.
#[derive(Debug)]
pub(super) struct Job<'m> {
    planner: Planner<'m>,
    pub(super) number: u64,
    mode: Mode,
    /// Once it is grounded, with a step for each of several objects that are moved.
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
            plan: Plan::empty(planner.model()),
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
        let task = self.planner.begin_grounding(scene, &self.parsed, self.step);
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
        let plan = plan.cloned();
        let (taken_ns, since_ns) = (*taken_ns, *since_ns);
        let scene = *task.scene();
        match plan {
            Ok(plan) => {
                if let Some((step, meant, found)) = self.meant.changed(&plan) {
                    return Err(Failure::OtherObject { step, meant, found });
                }
                self.meant.update(&plan, &scene);
                // Which objects are several, the first grounding decides for the whole sentence.
                self.parsed.clone_from(plan.parsed());
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
        let next = self.plan.numbered().next();
        // What is put on the table, or moved from where it was, stays there, whatever it stands beside.
        self.reference = next
            .filter(|(_, understood, _)| understood.reference.filters().is_other_object())
            .and_then(|(.., next)| self.view(&scene, limits).see(next.reference.object));
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

    fn steps(&self) -> usize {
        self.parsed.program().steps().len()
    }

    /// Whether the current step moves its object by a distance from where it is.
    fn is_shift(&self) -> bool {
        let step = self.parsed.program().steps().get(self.step);
        step.is_some_and(|step| step.reference.filters().is_itself())
    }
}
