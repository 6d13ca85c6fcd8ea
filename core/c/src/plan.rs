use nsrm_core::planner::{self, PlannedStep};

use crate::capacity::{MAX_RELATIONS, MAX_STEPS};
use crate::pointers::Sized32;

/// The object that a description refers to.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grounding {
    /// Id of the object.
    pub object: u32,
    /// How well it fits: the least cosine of the description's values and of its relation.
    pub score: f32,
    /// The probability that this object is meant, with all that the description relates it to.
    pub probability: f32,
    /// How many objects the description relates it to.
    pub anchor_count: u32,
    /// Their ids; 0 behind the last.
    pub anchors: [u32; MAX_RELATIONS],
}

/// The probabilities of a step's choices.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Confidence {
    /// That the step ends where the sentence was split.
    pub split: f32,
    /// That all words stand where commands have them.
    pub words: f32,
    /// That the action is right.
    pub action: f32,
    /// That the words' relations to each other are right.
    pub relations: f32,
    /// That these words describe the object to move.
    pub object: f32,
    /// That these words describe the reference.
    pub reference: f32,
    /// That the description refers to this object.
    pub object_unique: f32,
    /// That the description refers to this reference.
    pub reference_unique: f32,
}

/// One step of a plan: which object to move, and where.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SubGoal {
    /// Number of the step in the program, from 0.
    pub step: u32,
    /// Index of the action.
    pub action: u32,
    /// The object to move.
    pub object: Grounding,
    /// The reference; of the table, the object beside which there is room.
    pub reference: Grounding,
    /// Where the object's centre is to be: world frame, metres.
    pub position: [f32; 3],
    /// How it is to be turned: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Where it will be observed: box corners x1, y1, x2, y2 as fractions of the image, mean depth in
    /// metres; may lie outside the image.
    pub location: [f32; 5],
    /// The probabilities of the step's choices.
    pub confidence: Confidence,
}

/// A plan in a scene.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// `sizeof(nsrm_plan_t)`; set it before the call.
    pub size: u32,
    /// How many sub-goals there are.
    pub count: u32,
    /// The probability that every choice of the plan is right.
    pub confidence: f32,
    /// The sub-goals in the order of execution; 0 behind the last.
    pub sub_goals: [SubGoal; MAX_STEPS],
}

// SAFETY: the first field is the size.
unsafe impl Sized32 for Plan {}

impl From<&planner::Grounding> for Grounding {
    fn from(grounding: &planner::Grounding) -> Self {
        let mut copied = Self {
            object: grounding.object,
            score: grounding.score,
            probability: grounding.probability,
            ..Self::default()
        };
        for (place, anchor) in copied.anchors.iter_mut().zip(grounding.anchors()) {
            *place = *anchor;
            copied.anchor_count += 1;
        }
        copied
    }
}

impl From<&planner::Confidence> for Confidence {
    fn from(confidence: &planner::Confidence) -> Self {
        Self {
            split: confidence.split,
            words: confidence.words,
            action: confidence.action,
            relations: confidence.relations,
            object: confidence.object,
            reference: confidence.reference,
            object_unique: confidence.object_unique,
            reference_unique: confidence.reference_unique,
        }
    }
}

impl SubGoal {
    fn new(number: usize, step: &PlannedStep) -> Self {
        let pose = &step.sub_goal.pose;
        Self {
            // Below MAX_STEPS.
            step: number as u32,
            action: step.action.into(),
            object: (&step.object).into(),
            reference: (&step.reference).into(),
            position: pose.translation.vector.into(),
            orientation: pose.rotation.coords.into(),
            location: step.location,
            confidence: (&step.confidence).into(),
        }
    }
}

impl Plan {
    /// Without sub-goals.
    pub(crate) fn empty() -> Self {
        Self {
            size: size_of::<Self>() as u32,
            count: 0,
            confidence: 0.0,
            sub_goals: [SubGoal::default(); MAX_STEPS],
        }
    }
}

impl From<&planner::Plan> for Plan {
    fn from(plan: &planner::Plan) -> Self {
        let mut copied = Self {
            confidence: plan.confidence(),
            ..Self::empty()
        };
        for (place, (number, _, step)) in copied.sub_goals.iter_mut().zip(plan.numbered()) {
            *place = SubGoal::new(number, step);
            copied.count += 1;
        }
        copied
    }
}
