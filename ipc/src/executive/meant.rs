//! The objects that a sentence is about: those that were present when it was started.

use heapless::Vec;
use nsrm_core::dsl::Description;
use nsrm_core::scene::ObservedObject;
use nsrm_core::{MAX_OBJECTS, MAX_STEPS, Model, Plan, Scene};

/// The objects observed when the sentence was first grounded, and those that its steps refer to.
///
/// Objects that appear later do not count. Where blocks stand close together, a detector may take
/// parts of two for a third one, which would make "the blue block" ambiguous midway. Only if an
/// object that is referred to disappears do all objects count again.
#[derive(Debug, Default)]
pub(super) struct Meant {
    known: Vec<u32, MAX_OBJECTS>,
    /// Ids of object and reference of each step.
    steps: [Option<[u32; 2]>; MAX_STEPS],
}

impl Meant {
    /// The first of the remaining steps whose description means another object than before, with the
    /// ids of that one and of the other.
    ///
    /// What objects look like stays, so this is about descriptions that compare or relate them: the
    /// leftmost block is another one once the robot has dropped it to the right.
    pub(super) fn changed(&self, plan: &Plan) -> Option<(u8, u32, u32)> {
        let mut remaining = plan.numbered().filter_map(|(number, understood, planned)| {
            let [object, reference] = (*self.steps.get(number)?)?;
            let (moved, fixed) = (&planned.object, &planned.reference);
            [
                (&understood.object, object, moved.object),
                (&understood.reference, reference, fixed.object),
            ]
            .into_iter()
            .find(|(description, meant, found)| compares(description) && meant != found)
            .map(|(_, meant, found)| (number as u8, meant, found))
        });
        remaining.next()
    }

    /// Records how the rest of the sentence was grounded.
    pub(super) fn update(&mut self, plan: &Plan, scene: &Scene) {
        self.known = scene.objects().iter().map(|object| object.id).collect();
        let steps = self.steps.iter_mut().skip(plan.first());
        for (meant, step) in steps.zip(plan.steps()) {
            *meant = Some([step.object.object, step.reference.object]);
        }
    }

    /// A scene without the objects that have appeared since; the whole scene before the first
    /// grounding, or if an object that this step or a later one refers to is missing.
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
            // It has as many places as before.
            let _ = raw.push(*object);
        }
        // The objects are valid.
        Scene::new(raw, model).unwrap_or(*scene)
    }
}

/// Whether it says where an object is, and not only what it looks like.
fn compares(description: &Description) -> bool {
    !description.relations().is_empty() || description.filters().is_compared()
}
