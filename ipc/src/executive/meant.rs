//! Which objects a sentence is about: those that were there when it was begun.

use heapless::Vec;
use nsrm_core::scene::ObservedObject;
use nsrm_core::{MAX_OBJECTS, MAX_STEPS, Model, Plan, Scene};

/// What was observed when the sentence was grounded first, and what its steps mean of that.
///
/// What appears later is no object of the sentence. Where blocks stand close a detector may take
/// parts of two for another one, which would make "the blue block" ambiguous midway. Only where
/// something that is meant is gone all count again.
#[derive(Debug, Default)]
pub(super) struct Meant {
    known: Vec<u32, MAX_OBJECTS>,
    /// Ids of object and reference of each step.
    steps: [Option<[u32; 2]>; MAX_STEPS],
}

impl Meant {
    /// What is left of the sentence was grounded so.
    pub(super) fn update(&mut self, plan: &Plan, scene: &Scene) {
        self.known = scene.objects().iter().map(|object| object.id).collect();
        let steps = self.steps.iter_mut().skip(plan.first());
        for (meant, step) in steps.zip(plan.steps()) {
            *meant = Some([step.object.object, step.reference.object]);
        }
    }

    /// A scene without what has appeared since; all of it before the first grounding, or if
    /// something is not there that this step or a later one means.
    pub(super) fn only(&self, scene: &Scene, step: usize, model: &Model<'_>) -> Scene {
        let is_there = |id: &u32| scene.objects().iter().any(|object| object.id == *id);
        let mut left = self.steps.iter().skip(step).flatten().flatten();
        if self.known.is_empty() || !left.all(is_there) {
            return *scene;
        }
        let mut raw = *scene.raw();
        raw.objects = [ObservedObject::EMPTY; MAX_OBJECTS];
        raw.count = 0;
        let known = |object: &&ObservedObject| self.known.contains(&object.id);
        for object in scene.objects().iter().filter(known) {
            // As many places as before.
            let _ = raw.push(*object);
        }
        // Of sound objects.
        Scene::new(raw, model).unwrap_or(*scene)
    }
}
