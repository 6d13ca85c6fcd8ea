"""Time-parameterises paths within the maker's limits of speed, acceleration and jerk, with
Ruckig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from ruckig import InputParameter, Result, Ruckig
from ruckig import Trajectory as Timed

from nsrm_harness.geometry import panda
from nsrm_harness.manipulation.kinematics import Joints

SHARE = 0.95
"""Fraction of the limits that is used: a controller that follows a trajectory is sometimes ahead of
it."""
DEGREE = 7
"""Degree of the polynomial through the joints along a line."""
CHECKED = 200
"""Number of points at which the speeds along a line are checked."""


@dataclass(frozen=True, eq=False)
class Moments:
    """States of a trajectory: angles, speeds and accelerations at each of n times, `[n, 7]` each,
    rad, rad/s, rad/s²."""

    joints: NDArray[np.float64]
    speeds: NDArray[np.float64]
    accelerations: NDArray[np.float64]


class Trajectory(Protocol):
    """Joints over time, from rest to rest."""

    @property
    def duration_s(self) -> float:
        """Its duration."""
        ...

    @property
    def begin(self) -> Joints:
        """The joints at its beginning."""
        ...

    @property
    def end(self) -> Joints:
        """The joints at its end."""
        ...

    def at(self, times_s: NDArray[np.float64]) -> Moments:
        """Its states at these times; outside it, those at its ends."""
        ...


class Straight:
    """Moves all joints at once along a straight line in joint space, as fast as the slowest one
    allows."""

    def __init__(self, begin: Joints, end: Joints, pace: float = 1.0) -> None:
        """`pace`: fraction of the limits of speed, acceleration and jerk"""
        self.begin, self.end = begin, end
        self._turn = end - begin
        # Only the position along the line is timed: joints with separate profiles would leave it.
        speed, acceleration, jerk = (_least(limits, np.abs(self._turn)) for limits in _limits(pace))
        self._timed = rest_to_rest(speed, acceleration, jerk)

    @property
    def duration_s(self) -> float:
        return float(self._timed.duration)

    def at(self, times_s: NDArray[np.float64]) -> Moments:
        place, speed, acceleration = moments_of(self._timed, times_s)
        turn = self._turn
        return Moments(self.begin + place * turn, speed * turn, acceleration * turn)


class Backwards:
    """A trajectory from its end to its beginning."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.begin, self.end = trajectory.end, trajectory.begin
        self._trajectory = trajectory

    @property
    def duration_s(self) -> float:
        return self._trajectory.duration_s

    def at(self, times_s: NDArray[np.float64]) -> Moments:
        moments = self._trajectory.at(self.duration_s - times_s)
        return Moments(moments.joints, -moments.speeds, moments.accelerations)


class _Fitting(NamedTuple):
    """What fits polynomials to joints at equal distances along a path, as matrices: they are the
    same for every path of so many joints."""

    coefficients: NDArray[np.floating]
    """From the joints to the coefficients of Chebyshev polynomials, by least squares,"""
    values: NDArray[np.floating]
    """from these to the joints,"""
    derivatives: Sequence[NDArray[np.floating]]
    """and to those of the derivatives by the position along the path, which is from 0 to 1: half of
    Chebyshev's range."""


@cache
def _fitting(count: int) -> _Fitting:
    degree = min(DEGREE, count - 1)
    values = chebyshev.chebvander(np.linspace(-1.0, 1.0, count), degree)
    terms = np.eye(degree + 1)
    derivatives = [chebyshev.chebder(terms, order, scl=2) for order in (1, 2, 3)]
    return _Fitting(np.linalg.pinv(values), values, derivatives)


class Along:
    """A smooth motion through joints that lie densely along a path, such as those for a straight
    line of the hand: it passes through the first and the last of them, and close to the others.

    * `off_rad`: the largest deviation of a joint from any of them
    """

    def __init__(self, joints: Sequence[Joints], pace: float = 1.0) -> None:
        self.begin, self.end = joints[0], joints[-1]
        self._joints, self._pace = joints, pace
        fitting = _fitting(len(joints))
        path = fitting.coefficients @ np.array(joints)
        # The preceding motion ends at the first of them, and the next one begins at the last: no
        # joint may jump.
        off = np.array(joints) - fitting.values @ path
        path[:2] += (off[-1] + off[0]) / 2, (off[-1] - off[0]) / 2
        self.off_rad = float(np.abs(np.array(joints) - fitting.values @ path).max())
        self._turns = [path] + [each @ path for each in fitting.derivatives]
        self._timed = self._slowest(pace)

    @property
    def duration_s(self) -> float:
        return float(self._timed.duration)

    def at(self, times_s: NDArray[np.float64]) -> Moments:
        place, speed, acceleration = moments_of(self._timed, times_s)
        joints, first, second, _ = self._at_places(place[:, 0])
        return Moments(joints, first * speed, second * speed**2 + first * acceleration)

    def reversed(self) -> Along:
        """The same path in reverse."""
        return Along(self._joints[::-1], self._pace)

    def _at_places(self, places: NDArray[np.float64]) -> Sequence[NDArray[np.float64]]:
        """The joints and their derivatives `[n, 7]` at these positions along the path."""
        path, *_ = self._turns
        polynomials = chebyshev.chebvander(2 * places - 1, len(path) - 1)
        return [np.asarray(polynomials[:, : len(turn)] @ turn) for turn in self._turns]

    def _slowest(self, pace: float) -> Timed:
        """Timing along the path, so slow that no joint exceeds its limits anywhere."""
        _, first, second, third = (
            np.abs(turn).max(axis=0) for turn in self._at_places(np.linspace(0.0, 1.0, CHECKED))
        )
        speeds, accelerations, jerks = _limits(pace)
        # Assumes that all terms of a derivative are largest at once; each gets an equal share of
        # the limit.
        speed = _least(speeds, first)
        speed = min(speed, math.sqrt(_least(accelerations / 2, second)))
        speed = min(speed, math.cbrt(_least(jerks / 3, third)))
        acceleration = _least(accelerations / 2, first)
        acceleration = min(acceleration, _least(jerks / 9, second * speed))
        jerk = _least(jerks / 3, first)
        return rest_to_rest(speed, acceleration, jerk)


def _least(limits: NDArray[np.float64], factors: NDArray[np.float64]) -> float:
    """The largest number whose product with each factor is within that factor's limit."""
    return float((limits / np.maximum(factors, 1e-9)).min())


def moments_of(timed: Timed, times_s: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Position, speed and acceleration of one axis, `[n, 1]` each, at each of n times; outside it,
    those at its ends.

    Computed at once, from its segments of constant jerk: calling Ruckig for each time took 40 % of
    the planning.
    """
    ((profile,),) = timed.profiles
    ends_s = np.cumsum(profile.t)
    times_s = np.clip(times_s, 0.0, ends_s[-1])
    part = np.minimum(np.searchsorted(ends_s, times_s, side="right"), len(ends_s) - 1)
    since_s = times_s - np.concatenate(([0.0], ends_s))[part]
    position, speed, acceleration, jerk = (
        np.array(each)[part] for each in (profile.p, profile.v, profile.a, profile.j)
    )
    return [
        (position + since_s * (speed + since_s * (acceleration / 2 + since_s * jerk / 6)))[:, None],
        (speed + since_s * (acceleration + since_s * jerk / 2))[:, None],
        (acceleration + since_s * jerk)[:, None],
    ]


def _limits(pace: float) -> tuple[Joints, Joints, Joints]:
    """The limits of speed, acceleration and jerk that are used."""
    share = pace * SHARE
    return (
        share * panda.MAX_SPEED_RAD_S,
        share * panda.MAX_ACCELERATION_RAD_S2,
        share * panda.MAX_JERK_RAD_S3,
    )


def rest_to_rest(speed: float, acceleration: float, jerk: float) -> Timed:
    """Timing of the position along a path, from 0 to 1, within limits of its derivatives, from rest
    to rest."""
    wanted = InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [1.0]
    wanted.max_velocity, wanted.max_acceleration = [speed], [acceleration]
    wanted.max_jerk = [jerk]
    timed = Timed(1)
    result = Ruckig(1).calculate(wanted, timed)
    if result not in (Result.Working, Result.Finished):
        raise ValueError(f"no time-optimal profile at {speed}, {acceleration}, {jerk}: {result}")
    return timed
