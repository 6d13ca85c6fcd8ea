"""Where the arm is in tests."""

from __future__ import annotations

from nsrm_harness.arm import panda
from nsrm_harness.arm.grasp import pointing_down
from nsrm_harness.arm.kinematics import Joints, Kinematics

KINEMATICS = Kinematics()


def above(x: float, y: float, z: float) -> Joints:
    """With the fingertips there, from above."""
    joints = KINEMATICS.joints(pointing_down(x, y, z, 0.0), panda.READY_RAD)
    assert joints is not None
    return joints
