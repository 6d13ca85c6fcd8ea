"""Stops a motion: the arm brakes along its checked path, so that it comes no closer to anything
than planned, and knows its retreat path."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from ruckig import ControlInterface, InputParameter, Ruckig
from ruckig import Trajectory as Timed

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry import panda
from nsrm_harness.manipulation.grasps import Grasp
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.trajectory import (
    Backwards,
    Moments,
    Straight,
    Trajectory,
    moments_of,
    rest_to_rest,
)

BRAKING = [12.0 * 0.85**number for number in range(22)]
"""Decelerations of the pace along a trajectory, 1/s: the first one that exceeds no joint's
acceleration limit is used. The last one stops the arm within 3 s; of motions planned at 0.8 of the
limits, half stop within 0.15 s and all within 1 s."""
BRAKING_JERK = 200.0
"""1/s²; at the joints' full speed, a tenth of their limits."""
PACE, ACCELERATION, JERK = 0.3, 1.0, 10.0
"""Limits of pace, acceleration and jerk along a trajectory on the way back: a fraction of its own
pace, 1/s and 1/s²."""
LOOKED_S = 0.004
"""Sampling interval at which accelerations are checked while braking."""
BACK_PACE = 0.2
"""Fraction of the maker's limits with which the arm backs off from an obstacle."""
BACK_RAD = 0.01
"""How far back the arm rejoins its path, by the joint that turns most: there, the hand is some
millimetres off the obstacle and no longer pushes it."""

Stop = Callable[[], bool]
"""Whether the arm must stop; called at each tick."""


def never_stopped() -> bool:
    """Never stops."""
    return False


@dataclass(frozen=True, eq=False)
class RetreatPath:
    """The path from where the arm was stopped to its ready pose, on which it puts down what it
    holds.

    * `trajectories`: the first trajectories, with the fingers as they are
    * `grasp`: then the fingers open as far as it says; None if they hold nothing
    * `home`: the trajectories after that
    """

    trajectories: tuple[Trajectory, ...] = ()
    grasp: Grasp | None = None
    home: tuple[Trajectory, ...] = ()


class StoppedError(HarnessError):
    """The arm was stopped and stands still, with its fingers as they are."""

    def __init__(self, back: RetreatPath) -> None:
        super().__init__("the arm was stopped on its way and stands still there")
        self.back = back


class Braking:
    """Stops a trajectory: from one moment on, slows down along its path until it is at rest."""

    def __init__(self, trajectory: Trajectory, since_s: float) -> None:
        self._trajectory, self._since_s = trajectory, since_s
        for deceleration in BRAKING:
            self._timed = _slowed(deceleration)
            accelerations = self.at(np.arange(0.0, self.duration_s, LOOKED_S)).accelerations
            if np.all(np.abs(accelerations) <= panda.MAX_ACCELERATION_RAD_S2):
                break

    @property
    def duration_s(self) -> float:
        return float(self._timed.duration)

    @property
    def stopped_s(self) -> float:
        """The moment of the trajectory at which the arm comes to rest."""
        gone_s = float(self._timed.at_time(self.duration_s)[0][0])
        return min(self._since_s + gone_s, self._trajectory.duration_s)

    def at(self, times_s: NDArray[np.float64]) -> Moments:
        """Its states at these times."""
        gone_s, pace, change = moments_of(self._timed, times_s)
        return _at_pace(self._trajectory, self._since_s + gone_s, pace, change)


class PathPart:
    """A part of a trajectory, forwards or backwards, slowly and from rest to rest."""

    def __init__(self, trajectory: Trajectory, begin_s: float, end_s: float) -> None:
        self._trajectory, self._begin_s, self._span_s = trajectory, begin_s, end_s - begin_s
        self.begin, self.end = trajectory.at(np.array([begin_s, end_s])).joints
        span_s = max(abs(self._span_s), 1e-6)
        self._timed = rest_to_rest(PACE / span_s, ACCELERATION / span_s, JERK / span_s)

    @property
    def duration_s(self) -> float:
        return float(self._timed.duration)

    def at(self, times_s: NDArray[np.float64]) -> Moments:
        place, pace, change = (self._span_s * each for each in moments_of(self._timed, times_s))
        return _at_pace(self._trajectory, self._begin_s + place, pace, change)


def back_from(
    trajectories: Sequence[Trajectory], index: int, moment_s: float, then: RetreatPath
) -> RetreatPath:
    """The retreat path from a moment of one of these trajectories: back along them, and then
    `then`."""
    before = tuple(Backwards(each) for each in trajectories[:index][::-1])
    return replace(
        then,
        trajectories=(PathPart(trajectories[index], moment_s, 0.0), *before, *then.trajectories),
    )


def on_from(
    trajectories: Sequence[Trajectory], index: int, moment_s: float, then: RetreatPath
) -> RetreatPath:
    """The rest of these trajectories from a moment of one of them, and then `then`."""
    trajectory = trajectories[index]
    return replace(
        then,
        trajectories=(
            PathPart(trajectory, moment_s, trajectory.duration_s),
            *trajectories[index + 1 :],
            *then.trajectories,
        ),
    )


def reversed_from(joints: Joints, trajectory: Trajectory) -> tuple[Trajectory, Trajectory]:
    """Backs off from an obstacle that was met on a trajectory: rejoins the trajectory slightly
    before the contact, and follows it back to its beginning. No new path has to be checked: the
    trajectory has been, and on the short piece to it the arm is never farther off it than at
    first, where it was pushed to.

    * `joints`: where the arm is, less than a few hundredths of a radian off the trajectory
    """
    times_s = np.arange(0.0, trajectory.duration_s, LOOKED_S)
    path = trajectory.at(times_s).joints
    off_rad = np.abs(path - joints).max(axis=1)
    before = np.flatnonzero(off_rad[: int(off_rad.argmin())] >= BACK_RAD)
    index = int(before[-1]) if len(before) else 0
    return Straight(joints, path[index], BACK_PACE), PathPart(
        trajectory, float(times_s[index]), 0.0
    )


def _at_pace(
    trajectory: Trajectory,
    moments_s: NDArray[np.float64],
    pace: NDArray[np.float64],
    change: NDArray[np.float64],
) -> Moments:
    """The states of a trajectory at moments of it that pass at a pace `[n, 1]`, which changes,
    1/s."""
    own = trajectory.at(moments_s[:, 0])
    return Moments(own.joints, own.speeds * pace, own.accelerations * pace**2 + own.speeds * change)


def _slowed(deceleration: float) -> Timed:
    """A pace that slows from 1 to 0."""
    wanted = InputParameter(1)
    wanted.control_interface = ControlInterface.Velocity
    wanted.current_velocity, wanted.target_velocity = [1.0], [0.0]
    wanted.max_acceleration, wanted.max_jerk = [deceleration], [BRAKING_JERK]
    slowed = Timed(1)
    Ruckig(1).calculate(wanted, slowed)
    return slowed
