//! Commands for a controller: move an object to its sub-goal, or stop.

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use nsrm_core::{MAX_OBJECTS, MAX_STEPS};
use thiserror::Error;

use super::checks::{all_finite, is_unit};
use super::layout::message;
use super::numbers::numbers;
use crate::executive::{Command, CommandId};

message! {
    /// A command (service `sub_goal`): move an object to its sub-goal, or stop doing so. Each is
    /// acknowledged by a [`crate::message::Feedback`]; a repeated command gets the same answer and
    /// is not executed again.
    ///
    /// A delayed controller may read commands that are obsolete. Of all waiting commands it obeys
    /// stops first. It answers, but does not execute, a command that it reads after `until_ns`, or
    /// that is older than one it has received (with a smaller plan number, or with the same one and
    /// a smaller command number).
    "nsrm.v1.SubGoal.027c01d730571850"
    pub struct SubGoal {
        /// Number of the plan; a later plan has a greater number.
        pub plan: u64,
        /// The deadline for starting it, nanoseconds on the clock of the robot's processes: the
        /// machine's monotonic clock, or the wall clock on several hosts. Then the planner abandons
        /// it. 0 for a stop, which is never too late.
        pub until_ns: u64,
        /// Number of the command within its plan, from 1; a stop has the number of the command that
        /// it stops.
        pub command: u32,
        /// The number of a [`Kind`]; in a stop all fields below are 0.
        pub kind: u32,
        /// Number of the step, from 0.
        pub step: u32,
        /// Number of steps in the program.
        pub steps: u32,
        /// Index of the action in the model.
        pub action: u32,
        /// Id of the object to move.
        pub object_id: u32,
        /// Id of the reference object; of the table, of the object beside which there is room; of the
        /// object itself, its own.
        pub reference_id: u32,
        /// Product of the step's probabilities, 0 to 1.
        pub confidence: f32,
        /// Sub-goal position of the object's centre: world frame, metres.
        pub position: [f32; 3],
        /// Sub-goal orientation, world frame: x, y, z, w.
        pub orientation: [f32; 4],
        /// Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
        /// metres.
        pub location: [f32; 5],
        /// Ids of objects that must stay where they are, besides the reference: the objects and
        /// references of completed steps; 0 for none.
        pub keep: [u32; MAX_OBJECTS],
    }
}

numbers! {
    /// The kind of a command: [`SubGoal::kind`].
    "SubGoal.kind"
    pub enum Kind {
        /// Move the object to its sub-goal.
        Move = 1,
        /// Stop.
        Stop = 2,
    }
}

/// A checked command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Move an object to a pose.
    Move {
        /// Id of the object.
        object: u32,
        /// Pose of its centre: world frame, metres.
        pose: Isometry3<f32>,
    },
    /// Stop the command with this number.
    Stop,
}

/// Why a command is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SubGoalError {
    /// Unknown kind.
    #[error("sub-goal: unknown kind {0}; 1 is a move, 2 is a stop")]
    Kind(u32),
    /// Commands count from 1.
    #[error("sub-goal: command 0; commands count from 1")]
    NoCommand,
    /// Too many steps, none, or a step number after the last.
    #[error("sub-goal: step {step} of {steps}; steps count from 0 and are {MAX_STEPS} at most")]
    Step {
        /// The step number.
        step: u32,
        /// The number of steps.
        steps: u32,
    },
    /// An id is 0, or both are the same.
    #[error(
        "sub-goal: object {object} and reference {reference} must differ, and neither may be 0"
    )]
    Objects {
        /// Id of the object to move.
        object: u32,
        /// Id of the reference.
        reference: u32,
    },
    /// Position, location or confidence is infinite or not a number.
    #[error("sub-goal: a number is not finite")]
    NotFinite,
    /// The orientation is not a quaternion of length 1.
    #[error("sub-goal: orientation (x, y, z, w) must have length 1")]
    NotNormalised,
    /// The confidence is not from 0 to 1.
    #[error("sub-goal: confidence must lie from 0 to 1")]
    Confidence,
    /// It is valid, but its deadline has passed: it must not be started.
    #[error("sub-goal: read {by_ms} ms after its deadline; its plan was abandoned")]
    TooLate {
        /// By how much, milliseconds.
        by_ms: u64,
    },
}

impl SubGoal {
    const EMPTY: Self = Self {
        plan: 0,
        until_ns: 0,
        command: 0,
        kind: 0,
        step: 0,
        steps: 0,
        action: 0,
        object_id: 0,
        reference_id: 0,
        confidence: 0.0,
        position: [0.0; 3],
        orientation: [0.0; 4],
        location: [0.0; 5],
        keep: [0; MAX_OBJECTS],
    };

    /// A stop of this command.
    ///
    /// ```
    /// use nsrm_ipc::executive::CommandId;
    /// use nsrm_ipc::message::{Order, SubGoal};
    ///
    /// let id = CommandId { plan: 9, command: 2 };
    /// let stop = SubGoal::stop(id);
    /// assert_eq!(stop.id(), id);
    /// assert_eq!(stop.read(0), Ok(Order::Stop));
    /// ```
    pub const fn stop(id: CommandId) -> Self {
        Self {
            plan: id.plan,
            command: id.command,
            kind: Kind::Stop as u32,
            ..Self::EMPTY
        }
    }

    /// The command's identity.
    pub const fn id(&self) -> CommandId {
        CommandId {
            plan: self.plan,
            command: self.command,
        }
    }

    /// Checks the command; only its receiver knows whether the objects exist.
    ///
    /// * `now_ns`: the time, on the machine's clock
    pub fn read(&self, now_ns: u64) -> Result<Order, SubGoalError> {
        if self.command == 0 {
            return Err(SubGoalError::NoCommand);
        }
        match Kind::from_number(self.kind) {
            Some(Kind::Move) => self.read_move(now_ns),
            Some(Kind::Stop) => Ok(Order::Stop),
            None => Err(SubGoalError::Kind(self.kind)),
        }
    }

    fn read_move(&self, now_ns: u64) -> Result<Order, SubGoalError> {
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
        if now_ns > self.until_ns {
            let by_ms = (now_ns - self.until_ns) / 1_000_000;
            return Err(SubGoalError::TooLate { by_ms });
        }
        let [x, y, z] = self.position;
        let [i, j, k, w] = self.orientation;
        let turned = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        Ok(Order::Move {
            object,
            pose: Isometry3::from_parts(Translation3::new(x, y, z), turned),
        })
    }
}

impl From<&Command> for SubGoal {
    fn from(command: &Command) -> Self {
        let Command {
            id,
            until_ns,
            step,
            steps,
            planned,
            keep,
        } = command;
        let pose = &planned.sub_goal.pose;
        Self {
            plan: id.plan,
            until_ns: *until_ns,
            command: id.command,
            kind: Kind::Move as u32,
            step: (*step).into(),
            steps: (*steps).into(),
            action: planned.action.into(),
            object_id: planned.object.object,
            reference_id: planned.reference.object,
            confidence: planned.confidence.joint(),
            position: pose.translation.vector.into(),
            orientation: pose.rotation.coords.into(),
            location: planned.location,
            keep: *keep,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{CommandId, Kind, MAX_OBJECTS, Order, SubGoal, SubGoalError};

    /// A sub-goal that passes.
    pub(crate) fn sub_goal() -> SubGoal {
        SubGoal {
            plan: 7,
            until_ns: 9_000_000,
            command: 1,
            kind: Kind::Move as u32,
            step: 1,
            steps: 2,
            action: 0,
            object_id: 3,
            reference_id: 4,
            confidence: 0.9,
            position: [0.5, -0.1, 0.02],
            orientation: [0.0, 0.0, 0.6, 0.8],
            location: [0.1, 0.2, 0.3, 0.4, 1.0],
            keep: [0; MAX_OBJECTS],
        }
    }

    #[test]
    fn the_pose_keeps_position_and_the_order_of_the_quaternion() {
        let Ok(Order::Move { object: 3, pose }) = sub_goal().read(9_000_000) else {
            panic!("{:?}", sub_goal().read(9_000_000));
        };
        assert_eq!(pose.translation.vector.as_slice(), [0.5, -0.1, 0.02]);
        let turned = pose.rotation.coords; // x, y, z, w
        assert!((turned.z - 0.6).abs() < 1e-6 && (turned.w - 0.8).abs() < 1e-6);
    }

    #[test]
    fn a_stop_names_what_it_stops_and_nothing_else() {
        let id = CommandId {
            plan: 7,
            command: 2,
        };
        let stop = SubGoal::stop(id);
        assert_eq!(
            (stop.id(), stop.kind, stop.read(u64::MAX)),
            (id, Kind::Stop as u32, Ok(Order::Stop))
        );
    }

    #[test]
    fn each_fault_is_named() {
        type Break = fn(&mut SubGoal);
        let cases: [(Break, SubGoalError); 11] = [
            (|s| s.command = 0, SubGoalError::NoCommand),
            (|s| s.kind = 3, SubGoalError::Kind(3)),
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
            assert_eq!(broken.read(0), Err(expected));
        }
        let mut broken = sub_goal();
        broken.orientation[3] = f32::NAN;
        assert_eq!(broken.read(0), Err(SubGoalError::NotNormalised));
        let late = sub_goal().read(12_000_001);
        assert_eq!(late, Err(SubGoalError::TooLate { by_ms: 3 }));
    }
}
