//! The last part of a step: where its object will be.

use core::borrow::Borrow;

use nalgebra::{Isometry3, Translation3};

use super::super::distance::{at_distance, shifted_by};
use super::super::{Confidence, Grounding, PlannedStep, SubGoal};
use super::GroundingTask;
use crate::action::simulate_any;
use crate::camera::rotation;
use crate::dsl::Argument;
use crate::model::LOCATION;
use crate::refusal::{Quantity, Refusal};
use crate::scene::Scene;

impl<S: Borrow<Scene>> GroundingTask<'_, S> {
    /// Predicts where the object will be, and moves it there for the following steps.
    ///
    /// * `put`: where it is put, unless the action says so
    pub(super) fn act(
        &mut self,
        step: usize,
        action: u8,
        [object, reference]: [Grounding; 2],
        put: Option<[f32; LOCATION]>,
    ) -> Result<(), Refusal> {
        let not_finite = |quantity| Refusal::NotFinite {
            step: step as u8,
            quantity,
        };
        let [from, to] = [object, reference].map(|grounding| {
            // Always there: the index is that of an object of the scene.
            self.locations.get(usize::from(grounding.index)).copied()
        });
        let (from, to) = from.zip(to).ok_or(Refusal::InvalidModel)?;
        for (argument, grounding, location) in [
            (Argument::Object, object, &from),
            (Argument::Reference, reference, &to),
        ] {
            if !self.viewpoint.contains(location) {
                return Err(Refusal::OutsideTrainingView {
                    step: step as u8,
                    argument,
                    object: grounding.object,
                });
            }
        }
        let location = put.or_else(|| simulate_any(self.model, action, &from, &to));
        // Always there: an action, or a compound that leads to one place.
        let mut location = location.ok_or(Refusal::InvalidModel)?;
        let symbols = self.symbols(step)?;
        if let Some(mm) = symbols.distance_mm {
            location = match symbols.reference.filters().is_itself() {
                true => shifted_by(self.model, &self.viewpoint, &location, &to, mm),
                false => at_distance(self.model, &self.viewpoint, &location, &to, mm),
            };
        }
        if !location.iter().all(|number| number.is_finite()) {
            return Err(not_finite(Quantity::Location));
        }
        if let Some(place) = self.locations.get_mut(usize::from(object.index)) {
            *place = location;
        }
        let pose = self.pose(&location);
        let position: [f32; 3] = pose.translation.vector.into();
        let rotation: [f32; 4] = pose.rotation.coords.into();
        if !position.iter().chain(&rotation).all(|n| n.is_finite()) {
            return Err(not_finite(Quantity::Pose));
        }
        let bounds = self.model.header.work_space;
        if !bounds.contains(&position) {
            return Err(Refusal::OutsideWorkSpace {
                step: step as u8,
                object: object.object,
                position,
                bounds,
            });
        }
        let decisions = self.decisions(step)?;
        let confidence = Confidence {
            split: decisions.split,
            words: decisions.words,
            action: decisions.action,
            relations: decisions.relations,
            object: decisions.object,
            reference: decisions.reference,
            object_unique: object.probability,
            reference_unique: reference.probability,
        };
        self.plan.push(PlannedStep {
            action,
            object,
            reference,
            location: self.viewpoint.from_training(&location),
            sub_goal: SubGoal {
                object: object.object,
                pose,
            },
            confidence,
        });
        Ok(())
    }

    fn pose(&self, location: &[f32; LOCATION]) -> Isometry3<f32> {
        let camera = self.viewpoint.training();
        let centre = camera.locate(self.model.camera, location);
        Isometry3::from_parts(
            Translation3::from(centre.coords),
            rotation(&self.model.header.placed_orientation),
        )
    }
}
