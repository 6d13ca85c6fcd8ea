//! The first part of a step: which objects it describes.

use core::borrow::Borrow;

use heapless::Vec;

use super::super::Grounding;
use super::super::resolve::{LeftOut, Resolver, Within};
use super::super::sight::Sight;
use super::GroundingTask;
use crate::capacity::MAX_OBJECTS;
use crate::dsl::{Argument, Description, Quantifier};
use crate::grounding::Chosen;
use crate::refusal::Refusal;
use crate::scene::Scene;

impl<S: Borrow<Scene>> GroundingTask<'_, S> {
    /// Begins to resolve a description.
    pub(super) fn seek(&mut self, step: usize, argument: Argument) -> Result<(), Refusal> {
        self.resolver = Resolver::new(self.symbols(step)?.description(argument));
        Ok(())
    }

    /// One unit of work on a description; the object once it is found.
    pub(super) fn resolve(
        &mut self,
        step: usize,
        argument: Argument,
    ) -> Result<Option<Grounding>, Refusal> {
        let (resolver, description, within) = self.resolving(step, argument)?;
        resolver.poll(description, &within)
    }

    /// The same of a reference; the first of both of two, described together with the other one.
    pub(super) fn resolve_reference(&mut self, step: usize) -> Result<Option<Grounding>, Refusal> {
        let symbols = self.symbols(step)?;
        if symbols.reference.filters().quantifier() != Some(Quantifier::Both) {
            return self.resolve(step, Argument::Reference);
        }
        let (resolver, description, within) = self.resolving(step, Argument::Reference)?;
        let found = resolver.poll_several(description, &within, LeftOut::None)?;
        let Some(ids) = found else {
            return Ok(None);
        };
        let mut both = ids.iter().filter_map(|id| {
            let mut objects = within.scene.objects().iter();
            let index = objects.position(|object| object.id == *id)?;
            let certain = Chosen {
                index,
                score: 1.0,
                probability: 1.0,
            };
            Some(Grounding::new(*id, index as u8, &certain))
        });
        // Both of two are there.
        let (one, other) = both.next().zip(both.next()).ok_or(Refusal::InvalidModel)?;
        Ok(Some(one.related_to(&other)))
    }

    /// The same of several objects that are moved.
    pub(super) fn resolve_several(
        &mut self,
        step: usize,
        left_out: LeftOut,
    ) -> Result<Option<Vec<u32, MAX_OBJECTS, u8>>, Refusal> {
        let (resolver, description, within) = self.resolving(step, Argument::Object)?;
        resolver.poll_several(description, &within, left_out)
    }

    /// The resolver, and what it resolves.
    pub(super) fn resolving(
        &mut self,
        step: usize,
        argument: Argument,
    ) -> Result<(&mut Resolver, &Description, Within<'_>), Refusal> {
        // Always there: steps are counted up to the program's length.
        let symbols = self.plan.program().steps().get(step);
        let symbols = symbols.ok_or(Refusal::InvalidModel)?;
        let within = Within {
            model: self.model,
            scene: self.scene.borrow(),
            viewpoint: &self.viewpoint,
            locations: &self.locations,
            has_moved: !self.plan.steps().is_empty(),
            step,
            argument,
            each: self.plan.parsed().each(step, argument),
        };
        Ok((&mut self.resolver, symbols.description(argument), within))
    }

    /// Refuses a distance from what is seen in part: its place may be off by more than that.
    ///
    /// * `reference`: from what it is, the object itself if that is shifted
    pub(super) fn check_measured(
        &mut self,
        step: usize,
        reference: &Grounding,
    ) -> Result<(), Refusal> {
        let is_measured = self.symbols(step)?.distance_mm.is_some();
        let (_, _, within) = self.resolving(step, Argument::Reference)?;
        if is_measured && Sight::of(reference.index.into(), &within).is_rough {
            return Err(Refusal::HiddenReference {
                step: step as u8,
                object: reference.object,
            });
        }
        Ok(())
    }
}
