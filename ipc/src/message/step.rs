//! A step of a program, as a [`PlanReply`](super::PlanReply) tells it.

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::MAX_FILTERS;
use nsrm_core::dsl::{Description, Step};
use nsrm_core::planner::PlannedStep;

use super::checks::{all_finite, is_unit};
use super::layout::message;

message! {
    /// A step as understood and, where it is still to be done, as grounded.
    "nsrm.v1.StepMessage.9da5fff08c49f54d"
    pub struct StepMessage {
        /// Index of the action in the model.
        pub action: u32,
        /// How many concepts describe the object to be moved.
        pub object_count: u32,
        /// Those concepts, by their index in the model; 0 behind the last.
        pub object: [u8; MAX_FILTERS],
        /// How many concepts describe the reference.
        pub reference_count: u32,
        /// Those concepts.
        pub reference: [u8; MAX_FILTERS],
        /// Id of the object to be moved; 0 where the step is not grounded, and
        /// then all below is 0.
        pub object_id: u32,
        /// Id of the reference.
        pub reference_id: u32,
        /// How well the object fits its description, a cosine.
        pub object_score: f32,
        /// How well the reference fits.
        pub reference_score: f32,
        /// Probability of each choice: split, action, words of the object, words
        /// of the reference, object, reference.
        pub confidence: [f32; 6],
        /// Where the object's centre is to be: world frame, metres.
        pub position: [f32; 3],
        /// How it is to be turned, world frame: x, y, z, w.
        pub orientation: [f32; 4],
        /// Where the camera will see it, as predicted: x1, y1, x2, y2 as
        /// fractions of the image, mean depth in metres.
        pub location: [f32; 5],
    }
}

impl StepMessage {
    /// None.
    pub(super) const EMPTY: Self = Self {
        action: 0,
        object_count: 0,
        object: [0; MAX_FILTERS],
        reference_count: 0,
        reference: [0; MAX_FILTERS],
        object_id: 0,
        reference_id: 0,
        object_score: 0.0,
        reference_score: 0.0,
        confidence: [0.0; 6],
        position: [0.0; 3],
        orientation: [0.0; 4],
        location: [0.0; 5],
    };

    /// A step of a program, not grounded.
    pub(super) fn understood(step: &Step) -> Self {
        let (object_count, object) = concepts(&step.object);
        let (reference_count, reference) = concepts(&step.reference);
        Self {
            action: step.action.into(),
            object_count,
            object,
            reference_count,
            reference,
            ..Self::EMPTY
        }
    }

    /// And as it is grounded.
    pub(super) fn ground(&mut self, planned: &PlannedStep) {
        let (object, reference) = (&planned.object, &planned.reference);
        let confidence = &planned.confidence;
        let pose = &planned.sub_goal.pose;
        self.object_id = object.object;
        self.reference_id = reference.object;
        self.object_score = object.score;
        self.reference_score = reference.score;
        self.confidence = [
            confidence.split,
            confidence.action,
            confidence.object,
            confidence.reference,
            confidence.object_unique,
            confidence.reference_unique,
        ];
        self.position = pose.translation.vector.into();
        self.orientation = pose.rotation.coords.into();
        self.location = planned.location;
    }

    /// Whether it is still to be done.
    pub const fn is_grounded(&self) -> bool {
        self.object_id != 0
    }

    /// Whether what came from another process can be one.
    pub(super) fn makes_sense(&self) -> bool {
        let counts = [self.object_count, self.reference_count];
        let described = counts.iter().all(|count| *count <= MAX_FILTERS as u32);
        let numbers: [&[f32]; 4] = [
            &self.position,
            &self.location,
            &self.confidence,
            &[self.object_score, self.reference_score],
        ];
        let finite = numbers.into_iter().all(all_finite);
        described && finite && (!self.is_grounded() || is_unit(&self.orientation))
    }
}

/// How many concepts a description has, and which.
fn concepts(description: &Description) -> (u32, [u8; MAX_FILTERS]) {
    let mut places = [0; MAX_FILTERS];
    for (place, &concept) in places.iter_mut().zip(description.concepts()) {
        *place = concept;
    }
    // At most MAX_FILTERS.
    (description.concepts().len() as u32, places)
}
