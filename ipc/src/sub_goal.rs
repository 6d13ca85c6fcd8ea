//! What a controller is told: which object, where to.

use core::fmt;

use iceoryx2::prelude::ZeroCopySend;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use nsrm_core::MAX_STEPS;

use crate::layout::message;
use crate::number::{all_finite, is_unit};

message! {
    /// One sub-goal of a plan (service `sub_goal`, and inside of `PlanReply`).
    "nsrm.v1.SubGoal.8bf58ae0c76fbd8e"
    pub struct SubGoal {
        /// Number of the plan: [`crate::PlanRequest::sequence`] of its request.
        pub plan: u64,
        /// Place in the plan, from 0.
        pub step: u32,
        /// Steps of the plan.
        pub steps: u32,
        /// Index of the action in the model.
        pub action: u32,
        /// The object to be moved.
        pub object_id: u32,
        /// The object in relation to which it is moved.
        pub reference_id: u32,
        /// Product of the step's probabilities, 0 to 1.
        pub confidence: f32,
        /// Where the object's centre is to be: world frame, metres.
        pub position: [f32; 3],
        /// How it is to be turned, world frame: x, y, z, w.
        pub orientation: [f32; 4],
        /// Where the camera will see it, as predicted: x1, y1, x2, y2 as
        /// fractions of the image, mean depth in metres.
        pub location: [f32; 5],
    }
}

/// Why a sub-goal is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubGoalError {
    /// More steps than a plan has, none, or a place behind the last.
    Step {
        /// Place that it says it has.
        step: u32,
        /// Steps that it says there are.
        steps: u32,
    },
    /// An object's id is 0, or both are the same.
    Objects {
        /// Id of the object to be moved.
        object: u32,
        /// Id of the reference.
        reference: u32,
    },
    /// Position, location or confidence is infinite or not a number.
    NotFinite,
    /// The orientation is not a quaternion of length 1.
    NotNormalised,
    /// The confidence is no probability.
    Confidence,
}

impl fmt::Display for SubGoalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step { step, steps } => write!(
                f,
                "sub-goal: step {step} of {steps}; steps count from 0 and are {MAX_STEPS} at most"
            ),
            Self::Objects { object, reference } => write!(
                f,
                "sub-goal: object {object} and reference {reference} must be two objects, not 0"
            ),
            Self::NotFinite => f.write_str("sub-goal: a number is not finite"),
            Self::NotNormalised => {
                f.write_str("sub-goal: orientation (x, y, z, w) must have length 1")
            }
            Self::Confidence => f.write_str("sub-goal: confidence must lie from 0 to 1"),
        }
    }
}

impl core::error::Error for SubGoalError {}

impl SubGoal {
    /// What stands in the unused places of a reply.
    pub(crate) const EMPTY: Self = Self {
        plan: 0,
        step: 0,
        steps: 0,
        action: 0,
        object_id: 0,
        reference_id: 0,
        confidence: 0.0,
        position: [0.0; 3],
        orientation: [0.0; 4],
        location: [0.0; 5],
    };

    /// Whether it can be carried out by someone who knows its objects.
    pub fn check(&self) -> Result<(), SubGoalError> {
        let (step, steps) = (self.step, self.steps);
        if step >= steps || steps > MAX_STEPS as u32 {
            return Err(SubGoalError::Step { step, steps });
        }
        let (object, reference) = (self.object_id, self.reference_id);
        if object == 0 || reference == 0 || object == reference {
            return Err(SubGoalError::Objects { object, reference });
        }
        let numbers = [&self.position[..], &self.location, &[self.confidence]];
        if !numbers.into_iter().all(all_finite) {
            return Err(SubGoalError::NotFinite);
        }
        if !is_unit(&self.orientation) {
            return Err(SubGoalError::NotNormalised);
        }
        if !(0.0..=1.0).contains(&self.confidence) {
            return Err(SubGoalError::Confidence);
        }
        Ok(())
    }
}

/// The pose to bring the object to: world frame, metres.
impl TryFrom<&SubGoal> for Isometry3<f32> {
    type Error = SubGoalError;

    fn try_from(sub_goal: &SubGoal) -> Result<Self, SubGoalError> {
        sub_goal.check()?;
        let [x, y, z] = sub_goal.position;
        let [i, j, k, w] = sub_goal.orientation;
        Ok(Self::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)),
        ))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{SubGoal, SubGoalError};
    use nalgebra::Isometry3;

    /// A sub-goal that passes.
    pub(crate) fn sub_goal() -> SubGoal {
        SubGoal {
            plan: 7,
            step: 1,
            steps: 2,
            action: 0,
            object_id: 3,
            reference_id: 4,
            confidence: 0.9,
            position: [0.5, -0.1, 0.02],
            orientation: [0.0, 0.0, 0.6, 0.8],
            location: [0.1, 0.2, 0.3, 0.4, 1.0],
        }
    }

    #[test]
    fn the_pose_keeps_position_and_the_order_of_the_quaternion() {
        let pose = Isometry3::try_from(&sub_goal()).unwrap();
        assert_eq!(pose.translation.vector.as_slice(), [0.5, -0.1, 0.02]);
        let turned = pose.rotation.coords; // x, y, z, w
        assert!((turned.z - 0.6).abs() < 1e-6 && (turned.w - 0.8).abs() < 1e-6);
    }

    #[test]
    fn each_fault_is_named() {
        type Break = fn(&mut SubGoal);
        let cases: [(Break, SubGoalError); 9] = [
            (|s| s.step = 2, SubGoalError::Step { step: 2, steps: 2 }),
            (|s| s.steps = 9, SubGoalError::Step { step: 1, steps: 9 }),
            (
                |s| s.object_id = 0,
                SubGoalError::Objects {
                    object: 0,
                    reference: 4,
                },
            ),
            (
                |s| s.reference_id = 3,
                SubGoalError::Objects {
                    object: 3,
                    reference: 3,
                },
            ),
            (|s| s.position[2] = f32::NAN, SubGoalError::NotFinite),
            (|s| s.location[4] = f32::INFINITY, SubGoalError::NotFinite),
            (|s| s.confidence = f32::NAN, SubGoalError::NotFinite),
            (|s| s.orientation = [0.0; 4], SubGoalError::NotNormalised),
            (|s| s.confidence = 1.5, SubGoalError::Confidence),
        ];
        for (break_it, expected) in cases {
            let mut broken = sub_goal();
            break_it(&mut broken);
            assert_eq!(broken.check(), Err(expected));
        }
        let mut broken = sub_goal();
        broken.orientation[3] = f32::NAN;
        assert_eq!(broken.check(), Err(SubGoalError::NotNormalised));
    }
}
