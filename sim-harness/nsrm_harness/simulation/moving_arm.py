"""The Panda in the world's physics: motors in its joints, fingers that hold by friction."""

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
"""Of the motors' control, in each step."""
FINGER_FRICTION = 1.0
"""Of a finger's pad; with that of a block: 0.6 (docs/arm)."""
SPINNING_FRICTION, ROLLING_FRICTION = 0.005, 0.0001
GEAR_ERP, GEAR_FORCE_N = 0.1, 50.0
"""Of what keeps the two fingers equally far from the middle, as one motor moves both."""


class MovingArm:
    """One arm in a client of PyBullet, at rest and open at first."""

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
        """Has the motors hold these angles and speeds, rad and rad/s, from the next step on."""
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
        """Has the fingers move to this opening with at most this force, from the next step on."""
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
        """Has the fingers' pads rub so much less than rubber: 1 is as rubber, 0 is not at all."""
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
        """Between the fingers."""
        states = pybullet.getJointStates(self._body, self._fingers, physicsClientId=self._client)
        return float(sum(state[0] for state in states))

    def contact_points(self) -> Sequence[tuple[Any, ...]]:
        """PyBullet's, of the arm with anything."""
        return pybullet.getContactPoints(bodyA=self._body, physicsClientId=self._client)

    def link_name(self, index: int) -> str:
        """Of a link by PyBullet's index."""
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
