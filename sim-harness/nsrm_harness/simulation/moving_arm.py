"""The Panda in the world's physics: motors in its joints, and fingers that hold by friction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.arm import BASE_LINK, FINGER_REST_M, REST_JOINTS_RAD
from nsrm_harness.simulation.bullet import pybullet

POSITION_GAIN, SPEED_GAIN = 0.3, 1.0
"""Gains of the motors' controller in each step."""
FINGER_FRICTION = 1.0
"""Friction of a finger's pad; 0.6 on a block (docs/arm)."""
SPINNING_FRICTION, ROLLING_FRICTION = 0.005, 0.0001
GEAR_ERP, GEAR_FORCE_N = 0.1, 50.0
"""Parameters of the constraint that couples the two fingers, since one motor moves both."""


class MovingArm:
    """An arm in a PyBullet client, initially at rest with open fingers."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._body = pybullet.loadURDF(str(panda.URDF), useFixedBase=True, physicsClientId=client)
        infos = [
            pybullet.getJointInfo(self._body, joint, physicsClientId=client)
            for joint in range(pybullet.getNumJoints(self._body, physicsClientId=client))
        ]
        self._links = {info[12].decode(): joint for joint, info in enumerate(infos)}
        self._names = {joint: name for name, joint in self._links.items()}
        self._joints = [info[0] for info in infos if info[2] == pybullet.JOINT_REVOLUTE]
        self._fingers = [self._links[name] for name in panda.FINGERS]
        for joint, angle in zip(self._joints, REST_JOINTS_RAD, strict=True):
            pybullet.resetJointState(self._body, joint, angle, physicsClientId=client)
        for finger in self._fingers:
            pybullet.resetJointState(self._body, finger, FINGER_REST_M, physicsClientId=client)
        self.rub(1.0)
        gear = pybullet.createConstraint(
            self._body,
            self._fingers[0],
            self._body,
            self._fingers[1],
            pybullet.JOINT_GEAR,
            [1, 0, 0],
            [0, 0, 0],
            [0, 0, 0],
            physicsClientId=client,
        )
        pybullet.changeConstraint(
            gear, gearRatio=-1, erp=GEAR_ERP, maxForce=GEAR_FORCE_N, physicsClientId=client
        )
        self.drive(panda.READY_RAD, np.zeros(len(self._joints)))
        self.grip(panda.MAX_OPENING_M, panda.GRIP_N)

    def drive(self, joints: NDArray[np.float64], speeds: NDArray[np.float64]) -> None:
        """Sets the motors' target angles and speeds, rad and rad/s, from the next step on."""
        pybullet.setJointMotorControlArray(
            self._body,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=joints.tolist(),
            targetVelocities=speeds.tolist(),
            positionGains=[POSITION_GAIN] * len(self._joints),
            velocityGains=[SPEED_GAIN] * len(self._joints),
            forces=panda.MAX_TORQUE_NM,
            physicsClientId=self._client,
        )

    def grip(self, opening_m: float, force_n: float) -> None:
        """Sets the target opening and largest force of the fingers, from the next step on."""
        for finger in self._fingers:
            pybullet.setJointMotorControl2(
                self._body,
                finger,
                pybullet.POSITION_CONTROL,
                targetPosition=opening_m / 2,
                force=force_n,
                maxVelocity=panda.FINGER_SPEED_M_S,
                physicsClientId=self._client,
            )

    def rub(self, share: float) -> None:
        """Scales the friction of the fingers' pads: 1 is that of rubber, 0 none."""
        for finger in self._fingers:
            pybullet.changeDynamics(
                self._body,
                finger,
                lateralFriction=share * FINGER_FRICTION,
                spinningFriction=share * SPINNING_FRICTION,
                rollingFriction=share * ROLLING_FRICTION,
                physicsClientId=self._client,
            )

    def joints(self) -> NDArray[np.float64]:
        """The joints' angles `[7]`, radians."""
        states = pybullet.getJointStates(self._body, self._joints, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def opening_m(self) -> float:
        """Opening between the fingers."""
        states = pybullet.getJointStates(self._body, self._fingers, physicsClientId=self._client)
        return float(sum(state[0] for state in states))

    def contact_points(self) -> Sequence[tuple[Any, ...]]:
        """PyBullet's contact points of the arm with any body."""
        return pybullet.getContactPoints(bodyA=self._body, physicsClientId=self._client)

    def link_name(self, index: int) -> str:
        """The name of a link by PyBullet's index."""
        return self._names.get(index, BASE_LINK)

    def links(self) -> dict[str, Pose]:
        """The frame of each link in the world, by name."""
        states = pybullet.getLinkStates(
            self._body,
            list(self._links.values()),
            computeForwardKinematics=1,
            physicsClientId=self._client,
        )
        links = {BASE_LINK: Pose((0.0, 0.0, 0.0))}
        # Entries 4 and 5: the link's frame; 0 and 1 would be its centre of mass.
        for name, state in zip(self._links, states, strict=True):
            links[name] = Pose(tuple(state[4]), tuple(state[5]))
        return links
