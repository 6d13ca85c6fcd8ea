"""Forward and inverse kinematics of the arm, with Pinocchio."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as untyped
from numpy.typing import NDArray
from scipy.linalg import lapack as untyped_lapack

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose

# Pinocchio creates its names at import; a type checker cannot know them, nor those of LAPACK.
pinocchio: Any = untyped
lapack: Any = untyped_lapack

Joints = NDArray[np.float64]
"""Angles of the arm's seven joints `[7]`, radians."""

POSITION_M = 1e-5
ANGLE_RAD = 1e-4
"""Tolerances of a solution, in position and in angle."""
MAX_ROUNDS = 100
"""Maximum number of iterations from one initial guess."""
DAMPING = 1e-3
EASE = 0.5
"""Fraction of the remaining motion to the ready pose by which the elbow moves in one iteration."""
AT_EASE_RAD = 1e-4
"""The elbow has converged when its remaining motion would turn no joint by more than this."""
EASED_ROUNDS = MAX_ROUNDS // 2
"""After this many iterations, the elbow's preference is dropped in favour of the hand's pose: near
a joint limit the two work against each other, and the hand would never arrive."""
STALLED_ROUNDS = 10
NEARER = 0.9
"""From then on, the iteration ends unless, within so many rounds, the hand gets nearer by this
factor: of 505 descents, none that arrived was slower, and the others stood still."""
LEVER_M = 0.2
"""By how far an error in angle counts as one in position, metres a radian."""
LIMIT_MARGIN_RAD = 1e-3
"""Distance kept from the maker's limits: the motion along a line deviates from the joints found
here by as much (`paths.MAX_OFF_RAD`), and must not exceed the limits either."""
MAX_TURN_RAD = 0.3
"""Maximum rotation of any joint in one iteration: far from its goal, the hand does not move along a
line."""
BEGINNINGS = 8
"""Number of initial guesses: the joints as they are, the ready pose, and others around it."""
SPREAD_RAD = 0.6
"""Maximum offset of those from the ready pose."""
REMEMBERED = 1 << 14
"""Size of the cache, in solutions: a plan asks for the same ones again for each rotation after
which the block looks the same, for a smaller finger clearance, and after a regrasp. 12 MB."""
_DAMPED = DAMPING**2 * np.eye(6)
_LOCAL = pinocchio.ReferenceFrame.LOCAL
_LOWEST_RAD = panda.LOWEST_RAD + LIMIT_MARGIN_RAD
_HIGHEST_RAD = panda.HIGHEST_RAD - LIMIT_MARGIN_RAD


class Kinematics:
    """The arm's kinematics. Not thread-safe, because it holds buffers for its computations: use one
    for each thread."""

    def __init__(self) -> None:
        whole = pinocchio.buildModelFromUrdf(str(panda.URDF))
        fingers = [whole.getJointId(name) for name in whole.names if "finger" in name]
        self._model = pinocchio.buildReducedModel(whole, fingers, pinocchio.neutral(whole))
        self._data = self._model.createData()
        self._whole, self._whole_data = whole, whole.createData()
        self._links = {
            frame.name: index
            for index, frame in enumerate(whole.frames)
            if frame.type == pinocchio.FrameType.BODY
        }
        self._hand = self._model.getFrameId(panda.HAND_FRAME)
        self._remembered = lru_cache(REMEMBERED)(self._solve)
        self._reach = _Reach(self._model, self._hand)

    def hand(self, joints: Joints) -> Pose:
        """The pose of the hand's frame in the world."""
        pinocchio.forwardKinematics(self._model, self._data, joints)
        frame = pinocchio.updateFramePlacement(self._model, self._data, self._hand)
        x, y, z = (float(value) for value in frame.translation)
        i, j, k, w = (float(value) for value in pinocchio.Quaternion(frame.rotation).coeffs())
        return Pose((x, y, z), (i, j, k, w))

    def links(
        self, joints: Joints, opening_m: float
    ) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Rotation `[3, 3]` and position `[3]` of each link's frame in the world, by name."""
        finger = opening_m / 2
        pinocchio.framesForwardKinematics(
            self._whole, self._whole_data, np.array([*joints, finger, finger])
        )
        frames = self._whole_data.oMf
        return {
            name: (frames[index].rotation, frames[index].translation)
            for name, index in self._links.items()
        }

    def may_reach(self, hand: Pose) -> bool:
        """Whether the stretched arm would reach this pose if the joints had no limits."""
        return self._reach.includes(hand)

    def joints(self, hand: Pose, near: Joints) -> Joints | None:
        """Joint angles within the maker's limits for this pose of the hand: the first solution from
        a series of initial guesses that begins with `near`. None if there is none. The array is
        read-only, because it is cached and shared between callers.

        Cost: 0.2 ms for a reachable pose, 5 to 20 ms where joint limits rule it out, microseconds
        beyond the stretched arm and for cached poses.
        """
        return self._remembered(hand, near.astype(np.float64).tobytes())

    def _solve(self, hand: Pose, near: bytes) -> Joints | None:
        if not self.may_reach(hand):
            return None
        goal = pinocchio.SE3(hand.rotation(), np.array(hand.position))
        for beginning in _beginnings(np.frombuffer(near)):
            found = self._descend(goal, beginning)
            if found is not None:
                found.flags.writeable = False
                return found
        return None

    def _descend(self, goal: Any, joints: Joints) -> Joints | None:
        """Damped least squares (Levenberg-Marquardt), clamped to the limits. The hand's pose has
        priority; in its null space, the elbow comes as close to the ready pose as possible."""
        found = None
        least_m, nearer = math.inf, EASED_ROUNDS
        joints = _within_limits(joints)
        for number in range(MAX_ROUNDS):
            pinocchio.forwardKinematics(self._model, self._data, joints)
            at = pinocchio.updateFramePlacement(self._model, self._data, self._hand)
            # In the hand's frame: metres, then radians.
            error = pinocchio.log6(at.actInv(goal)).vector
            jacobian = pinocchio.computeFrameJacobian(
                self._model, self._data, joints, self._hand, _LOCAL
            )
            x, y, z, i, j, k = error.tolist()
            off_m, turned_rad = math.hypot(x, y, z), math.hypot(i, j, k)
            is_there = off_m < POSITION_M and turned_rad < ANGLE_RAD
            eases = number < EASED_ROUNDS
            if is_there:
                found = joints
                if not eases:
                    break
            elif not eases:
                if off_m + LEVER_M * turned_rad < NEARER * least_m:
                    least_m, nearer = off_m + LEVER_M * turned_rad, number
                elif number - nearer >= STALLED_ROUNDS:
                    break
            to_ready = panda.READY_RAD - joints
            # Solved for at once: what moves the hand to its goal, and what would move it as the
            # elbow's way to its ready pose does.
            wanted = np.empty((6, 2), order="F")
            wanted[:, 0], wanted[:, 1] = error, jacobian @ to_ready
            _, solved, _ = lapack.dposv(jacobian @ jacobian.T + _DAMPED, wanted)
            turn, with_elbow = (jacobian.T @ solved).T
            if eases:
                # In the null space: it moves the elbow, but not the hand.
                ease = to_ready - with_elbow
                if is_there and _greatest(ease) < AT_EASE_RAD:
                    break
                turn = turn + EASE * ease
            greatest = _greatest(turn)
            if greatest > MAX_TURN_RAD:
                turn = turn * (MAX_TURN_RAD / greatest)
            joints = _within_limits(joints + turn)
        return found


def _within_limits(joints: Joints) -> Joints:
    # Numpy's clip takes twice as long for so few numbers.
    return np.minimum(np.maximum(joints, _LOWEST_RAD), _HIGHEST_RAD)


def _greatest(turn: Joints) -> float:
    """The largest rotation of any joint."""
    return max(map(abs, turn.tolist()))


class _Reach:
    """Where the hand could be if the joints had no limits; elsewhere inverse kinematics need not be
    tried.

    The shoulder (joints 1 and 2) and the wrist (joints 5 and 6) are at most as far apart as upper
    arm and forearm together are long. The wrist lies on a circle around the hand's axis.
    """

    def __init__(self, model: Any, hand: int) -> None:
        # The position of each joint in the frame of the one before it.
        place = {
            joint: model.jointPlacements[joint].translation for joint in range(1, panda.JOINTS + 1)
        }
        self._shoulder = np.array(place[1])
        # Joint 3 turns about the upper arm, and its offset to joint 4 is perpendicular to that.
        upper_m = math.hypot(*place[3], *place[4])
        self._aside_m = float(np.linalg.norm(place[7]))
        self._behind_m = float(model.frames[hand].placement.translation[2])
        slack_m = POSITION_M + ANGLE_RAD * (self._aside_m + self._behind_m)
        self._most_m = upper_m + float(np.linalg.norm(place[5])) + slack_m

    def includes(self, hand: Pose) -> bool:
        x, y, z = hand.rotation().T @ (self._shoulder - hand.position)
        to_circle_m = math.hypot(math.hypot(x, y) - self._aside_m, z + self._behind_m)
        return to_circle_m <= self._most_m


def _beginnings(near: Joints) -> Iterator[Joints]:
    yield near
    yield panda.READY_RAD
    # A fixed seed: the same guesses in every process.
    rng = np.random.default_rng(0)
    for _ in range(BEGINNINGS - 2):
        yield panda.READY_RAD + rng.uniform(-SPREAD_RAD, SPREAD_RAD, panda.JOINTS)
