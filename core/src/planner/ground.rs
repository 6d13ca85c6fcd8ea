mod act;
mod describe;

use core::borrow::Borrow;
use core::task::Poll;

use super::resolve::{LeftOut, Resolver};
use super::room::{self, Beside, Room};
use super::{Grounding, Plan};
use crate::calibration::{CalibrationFault, Cause, check_as_given, explains};
use crate::capacity::{MAX_OBJECTS, MAX_STEPS};
use crate::dsl::{Argument, Description, Property, Quantifier, Step};
use crate::language::{Parsed, StepDecisions};
use crate::model::{CompoundKind, LOCATION, Model};
use crate::refusal::Refusal;
use crate::scene::Scene;
use crate::viewpoint::Viewpoint;

/// Grounds a parsed sentence in a scene (sections IV-C and IV-D), from any step on, so that the
/// rest of a program can be planned again in each observed scene. Each [`GroundingTask::poll`] does
/// one of: the calibration check, one object's score, one choice of an object, one place on the
/// table, or one action. All scratch memory is in here.
///
/// A step that moves several objects is replaced by one for each of them before it is grounded.
///
/// `S` is the scene: borrowed, or owned where the task outlives the call that began it.
#[derive(Debug, Clone)]
pub struct GroundingTask<'m, S> {
    model: &'m Model<'m>,
    scene: S,
    viewpoint: Viewpoint<'m>,
    /// Where the objects are after the steps so far, as the training's camera would see them.
    locations: [[f32; LOCATION]; MAX_OBJECTS],
    resolver: Resolver,
    room: Room,
    plan: Plan,
    stage: Stage,
}

/// The state of a grounding task. Steps count from 0.
#[derive(Debug, Clone, Copy)]
enum Stage {
    /// The scene is compared with the camera's calibration.
    Check {
        step: usize,
    },
    /// It disagrees; the next cause may explain it.
    Explain {
        fault: CalibrationFault,
        cause: usize,
    },
    /// The object to move is sought.
    Object {
        step: usize,
    },
    /// The reference is sought, before the objects if several are moved.
    Reference {
        step: usize,
        object: Option<Grounding>,
    },
    /// The objects to move are sought.
    Several {
        step: usize,
        left_out: LeftOut,
    },
    /// A free place on the table is sought: anywhere, or beside the reference.
    Room {
        step: usize,
        object: Grounding,
    },
    /// A place between the reference and what is described together with it is sought.
    Between {
        step: usize,
        object: Grounding,
        reference: Grounding,
    },
    Act {
        step: usize,
        action: u8,
        object: Grounding,
        reference: Grounding,
        /// Where the object is put, unless the action says so.
        put: Option<[f32; LOCATION]>,
    },
    Done(Option<Refusal>),
}

impl<'m, S: Borrow<Scene>> GroundingTask<'m, S> {
    pub(super) fn new(model: &'m Model<'m>, scene: S, parsed: Parsed, first: usize) -> Self {
        let checked =
            check_model(model, scene.borrow()).and_then(|()| check_parsed(model, &parsed));
        let first = first.min(parsed.program().steps().len());
        let viewpoint = Viewpoint::new(model, scene.borrow().camera());
        let mut locations = [[0.0; LOCATION]; MAX_OBJECTS];
        for (location, object) in locations.iter_mut().zip(scene.borrow().objects()) {
            *location = viewpoint.to_training(&object.location);
        }
        let mut task = Self {
            model,
            // At most MAX_STEPS.
            plan: Plan::new(parsed, first as u8),
            scene,
            viewpoint,
            locations,
            resolver: Resolver::new(&Description::new()),
            room: Room::anywhere(),
            stage: Stage::Done(checked.err()),
        };
        if checked.is_ok() {
            task.stage = task.begin_program(first);
        }
        task
    }

    /// The scene that it is grounded in.
    pub fn scene(&self) -> &Scene {
        self.scene.borrow()
    }

    /// What the sentence says; once it is grounded, with a step for each of several objects.
    pub const fn parsed(&self) -> &Parsed {
        self.plan.parsed()
    }

    /// Starts with this sentence instead, in a task that has not started yet.
    pub(super) fn begin(&mut self, parsed: &Parsed) {
        self.plan = Plan::new(parsed.clone(), 0);
        self.stage = self.begin_program(0);
    }

    /// Whether grounding has failed.
    pub(super) const fn is_refused(&self) -> bool {
        matches!(self.stage, Stage::Done(Some(_)))
    }

    /// Does one unit of work, at most [`super::UNIT_MULTIPLY_ADDS`]. Once it is done, every further
    /// call returns the same result. The plan is the task's own; clone it to keep it longer.
    pub fn poll(&mut self) -> Poll<Result<&Plan, Refusal>> {
        self.stage = match self.advance(self.stage) {
            Ok(stage) => stage,
            Err(refusal) => Stage::Done(Some(refusal)),
        };
        match self.stage {
            Stage::Done(None) => Poll::Ready(Ok(&self.plan)),
            Stage::Done(Some(refusal)) => Poll::Ready(Err(refusal)),
            _ => Poll::Pending,
        }
    }

    fn advance(&mut self, stage: Stage) -> Result<Stage, Refusal> {
        match stage {
            Stage::Check { step } => Ok(match check_as_given(self.model, self.scene()) {
                Ok(()) => self.begin_step(step)?,
                Err(fault) => Stage::Explain { fault, cause: 0 },
            }),
            Stage::Explain { fault, cause } => {
                let Some(&next) = Cause::ALL.get(cause) else {
                    return Err(Refusal::Calibration(fault));
                };
                if explains(next, &fault, self.model, self.scene()) {
                    let cause = Some(next);
                    return Err(Refusal::Calibration(CalibrationFault { cause, ..fault }));
                }
                let cause = cause.saturating_add(1);
                Ok(Stage::Explain { fault, cause })
            }
            Stage::Object { step } => match self.resolve(step, Argument::Object)? {
                Some(object) => self.with_object(step, object),
                None => Ok(stage),
            },
            Stage::Reference { step, object } => match self.resolve_reference(step)? {
                Some(reference) => self.with_reference(step, object, reference),
                None => Ok(stage),
            },
            Stage::Several { step, left_out } => match self.resolve_several(step, left_out)? {
                Some(ids) => self.with_several(step, &ids),
                None => Ok(stage),
            },
            Stage::Room { step, object } => {
                let mut room = self.room;
                let (_, _, within) = self.resolving(step, Argument::Reference)?;
                let beside = room.poll(object.index.into(), &within)?;
                self.room = room;
                Ok(match beside {
                    Some(Beside { action, neighbour }) => Stage::Act {
                        step,
                        action,
                        object,
                        reference: neighbour,
                        put: None,
                    },
                    None => stage,
                })
            }
            Stage::Between {
                step,
                object,
                reference,
            } => {
                let action = self.symbols(step)?.action;
                let part = self.model.read_action(action);
                let part = part.ok_or(Refusal::InvalidModel)?;
                let (_, _, within) = self.resolving(step, Argument::Reference)?;
                let put = room::between(object.index.into(), &reference, part, &within)?;
                Ok(Stage::Act {
                    step,
                    action,
                    object,
                    reference,
                    put: Some(put),
                })
            }
            Stage::Act {
                step,
                action,
                object,
                reference,
                put,
            } => {
                self.act(step, action, [object, reference], put)?;
                self.begin_step(step.saturating_add(1))
            }
            Stage::Done(refusal) => Ok(Stage::Done(refusal)),
        }
    }

    /// If there is nothing to do, nothing is checked.
    fn begin_program(&self, first: usize) -> Stage {
        if first < self.plan.program().steps().len() {
            Stage::Check { step: first }
        } else {
            Stage::Done(None)
        }
    }

    fn begin_step(&mut self, step: usize) -> Result<Stage, Refusal> {
        let Some(symbols) = self.plan.program().steps().get(step) else {
            return Ok(Stage::Done(self.doubt()));
        };
        if let Some(Quantifier::All | Quantifier::Both) = symbols.object.filters().quantifier() {
            let left_out = match symbols.reference.filters().choice() {
                Some(Property::Table) => Some(LeftOut::OnTable),
                Some(Property::Itself) => Some(LeftOut::None),
                _ => None,
            };
            if let Some(left_out) = left_out {
                self.seek(step, Argument::Object)?;
                return Ok(Stage::Several { step, left_out });
            }
            self.seek(step, Argument::Reference)?;
            return Ok(Stage::Reference { step, object: None });
        }
        self.seek(step, Argument::Object)?;
        Ok(Stage::Object { step })
    }

    /// What follows once the object to move is known.
    fn with_object(&mut self, step: usize, object: Grounding) -> Result<Stage, Refusal> {
        match self.symbols(step)?.reference.filters().choice() {
            Some(Property::Table) => return self.begin_room(step, object),
            Some(Property::Itself) => return self.begin_shift(step, object),
            _ => {}
        }
        self.seek(step, Argument::Reference)?;
        let object = Some(object);
        Ok(Stage::Reference { step, object })
    }

    /// What follows once the reference is known.
    ///
    /// * `object`: none yet if several are moved
    fn with_reference(
        &mut self,
        step: usize,
        object: Option<Grounding>,
        reference: Grounding,
    ) -> Result<Stage, Refusal> {
        self.check_measured(step, &reference)?;
        let Some(object) = object else {
            self.seek(step, Argument::Object)?;
            let left_out = LeftOut::Object(reference.index);
            return Ok(Stage::Several { step, left_out });
        };
        if reference.index == object.index {
            return Err(Refusal::SameObject {
                step: step as u8,
                object: object.object,
            });
        }
        let symbols = self.symbols(step)?;
        let action = symbols.action;
        let compound = self.model.compound(action);
        if compound.is_some_and(|compound| compound.kind == CompoundKind::Any) {
            self.room = Room::beside(reference, action, symbols.distance_mm);
            return Ok(Stage::Room { step, object });
        }
        if self.model.is_between(action) {
            return Ok(Stage::Between {
                step,
                object,
                reference,
            });
        }
        Ok(Stage::Act {
            step,
            action,
            object,
            reference,
            put: None,
        })
    }

    /// Puts a step for each object in the place of one that moves several.
    fn with_several(&mut self, step: usize, ids: &[u32]) -> Result<Stage, Refusal> {
        let symbols = self.symbols(step)?;
        let is_among = symbols.reference.filters().is_itself() && symbols.distance_mm.is_none();
        let (moved, stays) = match ids.split_last() {
            // The lowest one stays.
            Some((stays, moved)) if is_among => (moved, Some(*stays)),
            _ => (ids, None),
        };
        if moved.is_empty() {
            return Err(Refusal::OtherNumber {
                step: step as u8,
                description: symbols.object,
                expected: 2,
                got: 1,
            });
        }
        if !self.plan.expand(step, moved, stays) {
            let limit = MAX_STEPS as u8;
            return Err(Refusal::TooManySteps { limit });
        }
        self.begin_step(step)
    }

    /// The object is to be put on the table.
    fn begin_room(&mut self, step: usize, object: Grounding) -> Result<Stage, Refusal> {
        let (_, _, within) = self.resolving(step, Argument::Reference)?;
        if within.is_on_table(object.index.into()) {
            return Err(Refusal::AlreadyOnTable {
                step: step as u8,
                object: object.object,
            });
        }
        self.room = Room::anywhere();
        Ok(Stage::Room { step, object })
    }

    /// The object is to be moved by a distance from where it is, along the table.
    fn begin_shift(&mut self, step: usize, object: Grounding) -> Result<Stage, Refusal> {
        self.check_measured(step, &object)?;
        let (_, _, within) = self.resolving(step, Argument::Object)?;
        if !within.is_on_table(object.index.into()) {
            return Err(Refusal::NotOnTable {
                step: step as u8,
                object: object.object,
            });
        }
        Ok(Stage::Act {
            step,
            action: self.symbols(step)?.action,
            object,
            reference: object,
            put: None,
        })
    }

    /// Why the finished plan is refused, if it is.
    fn doubt(&self) -> Option<Refusal> {
        let confidence = self.plan.confidence();
        let threshold = self.model.header.thresholds.confidence;
        (confidence < threshold).then_some(Refusal::LowConfidence {
            confidence,
            threshold,
        })
    }

    fn symbols(&self, step: usize) -> Result<Step, Refusal> {
        // Always there: steps are counted up to the program's length.
        let steps = self.plan.program().steps();
        steps.get(step).copied().ok_or(Refusal::InvalidModel)
    }

    fn decisions(&self, step: usize) -> Result<StepDecisions, Refusal> {
        // There are as many as steps.
        let decisions = self.plan.parsed().decisions();
        decisions.get(step).copied().ok_or(Refusal::InvalidModel)
    }
}

/// Whether a scene's embeddings are from this model, and the model knows the objects' sizes.
pub(super) fn check_model(model: &Model<'_>, scene: &Scene) -> Result<(), Refusal> {
    let (expected, got) = (model.tag(), scene.header().model_tag);
    if expected != got {
        return Err(Refusal::OtherModel { expected, got });
    }
    if !model.has_edges() {
        return Err(Refusal::InvalidModel);
    }
    Ok(())
}

/// Whether this model parsed the sentence.
fn check_parsed(model: &Model<'_>, parsed: &Parsed) -> Result<(), Refusal> {
    let (expected, got) = (model.tag(), parsed.model_tag());
    if expected == got {
        Ok(())
    } else {
        Err(Refusal::ParsedByOtherModel { expected, got })
    }
}
