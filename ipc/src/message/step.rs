//! A step of a program in a [`PlanReply`](super::PlanReply).

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::MAX_FILTERS;
use nsrm_core::dsl::{Description, Step};
use nsrm_core::planner::PlannedStep;

use super::checks::{all_finite, is_unit};
use super::layout::message;

message! {
    /// A step as parsed and, if it is still to be done, as grounded.
    "nsrm.v1.StepMessage.256bedace904e745"
    pub struct StepMessage {
        /// Index of the action in the model.
        pub action: u32,
        /// How many concepts describe the object to move.
        pub object_count: u32,
        /// Those concepts: indices in the model; 0 after the last.
        pub object: [u8; MAX_FILTERS],
        /// How many concepts describe the reference.
        pub reference_count: u32,
        /// Those concepts.
        pub reference: [u8; MAX_FILTERS],
        /// Id of the object to move; 0 if the step is not grounded, and then all fields below are
        /// 0.
        pub object_id: u32,
        /// Id of the reference.
        pub reference_id: u32,
        /// How well the object fits its description, a cosine.
        pub object_score: f32,
        /// How well the reference fits.
        pub reference_score: f32,
        /// Probability of each choice: split, acceptable words, action, words of the object, words
        /// of the reference, object, reference.
        pub confidence: [f32; 7],
        /// Sub-goal position of the object's centre: world frame, metres.
        pub position: [f32; 3],
        /// Sub-goal orientation, world frame: x, y, z, w.
        pub orientation: [f32; 4],
        /// Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
        /// metres.
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
        confidence: [0.0; 7],
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

    /// The same step, grounded.
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
            confidence.words,
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

    /// Whether a received step is valid.
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

/// The number of concepts in a description, and the concepts.
fn concepts(description: &Description) -> (u32, [u8; MAX_FILTERS]) {
    let mut places = [0; MAX_FILTERS];
    for (place, &concept) in places.iter_mut().zip(description.concepts()) {
        *place = concept;
    }
    // At most MAX_FILTERS.
    (description.concepts().len() as u32, places)
}
