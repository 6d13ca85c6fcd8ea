"""What was planned, carried out tick by tick: the joints follow, the fingers close, and what
they hold is felt by how far they are open."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from nsrm_harness.manipulation.grasps import Grasp
from nsrm_harness.manipulation.gripper import close_fingers, open_fingers
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlace
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError, wait
from nsrm_harness.manipulation.stopping import (
    Braking,
    RetreatPath,
    Stop,
    StoppedError,
    back_along,
    back_from,
    never_stopped,
    on_from,
)
from nsrm_harness.manipulation.trajectory import Backwards, Moments, Trajectory

WIDTH_M = 0.004
"""The fingers hold a block when they are open as far as it is wide, within that."""
SLIP_M = 0.002
"""What they hold is lost when they close by more than that."""
CALM_S = 0.1
"""Before the fingers open, so that nothing swings."""
LAG_RAD = 0.02
"""Joints that follow are behind by less than that: at full speed, 2.6 rad/s, that would be 8 ms."""
TOUCH_RAD = 0.0025
"""While the hand or a block is lowered, slowly, they are behind by 0.001; by more than that, it has
met something before it was to."""
ARRIVED_RAD = 0.002
"""Where the fingers are moved next they have stopped nearer than that. Not between two motions:
what was met may push for a while yet."""


Mark = Callable[[str], None]
"""Is told what has just been done."""


def unmarked(event: str) -> None:
    """Tells nobody."""


class ExecutionResult(Enum):
    """How a carrying ended, as far as the hand can feel."""

    PLACED = "placed"
    NOT_GRASPED = "not grasped"
    SLIPPED = "slipped"
    TAKEN_BACK = "taken back, as something is in the way"


def execute(
    body: RobotInterface, carry: PickAndPlace, mark: Mark = unmarked, stop: Stop = never_stopped
) -> ExecutionResult:
    """Does all that was planned, and ends in the ready pose whatever happens to the block.

    Bounded: motions by their durations, fingers as in `open_fingers`. Raises `StuckError`, of the
    fingers `GripperError`; `StoppedError` where it was told to stop.
    """
    grasp = carry.grasp
    # First, while the arm stands: what was looked at is the arm with its fingers so.
    begin = carry.reach[0].begin
    body.drive(begin, np.zeros_like(begin))
    open_fingers(body, grasp.opening_m)
    _follow(body, carry.reach, _Halt(stop, back_from, RetreatPath()))
    from_here = RetreatPath(ways=tuple(Backwards(way) for way in carry.reach[::-1]))
    try:
        _follow(body, [carry.descend], _Halt(stop, back_from, from_here), lag_rad=TOUCH_RAD)
    except StuckError:
        up = back_along(body.joints(), carry.descend)
        _follow(body, (*up, *carry.back), _Halt(stop, on_from, RetreatPath()))
        mark("not grasped")
        return ExecutionResult.NOT_GRASPED
    mark("reached")
    held_m = close_fingers(body)
    away = RetreatPath(grasp=grasp, home=(carry.lift, *carry.back))
    if abs(held_m - grasp.width_m) > WIDTH_M:
        open_fingers(body, grasp.opening_m)
        _follow(body, away.home, _Halt(stop, on_from, RetreatPath()))
        mark("not grasped")
        return ExecutionResult.NOT_GRASPED
    mark("grasped")
    least_m = held_m - SLIP_M
    if not _follow(body, [carry.lift], _Halt(stop, back_from, away), least_m):
        return _without_it(body, grasp, carry.back, mark, stop)
    mark("lifted")
    down = replace(away, ways=(Backwards(carry.lift),))
    if not _follow(body, carry.transfer, _Halt(stop, back_from, down), least_m):
        return _without_it(body, grasp, carry.home, mark, stop)
    mark("above")
    back = tuple(Backwards(way) for way in carry.transfer[::-1])
    over = replace(down, ways=(*back, *down.ways))
    try:
        holds = _follow(body, [carry.lower], _Halt(stop, back_from, over), least_m, TOUCH_RAD)
    except StuckError:
        return _take_back(body, carry, mark, stop)
    wait(body, CALM_S)
    open_fingers(body, grasp.opening_m)
    mark("let go")
    _follow(body, (carry.retreat, *carry.home), _Halt(stop, on_from, RetreatPath()))
    mark("home")
    return ExecutionResult.PLACED if holds else ExecutionResult.SLIPPED


def retreat(body: RobotInterface, back: RetreatPath, stop: Stop = never_stopped) -> None:
    """What was held is put down where it was taken, and the arm goes to where it began.

    Raises `StuckError` and `StoppedError`, as `execute`.
    """
    _follow(body, back.ways, _Halt(stop, on_from, replace(back, ways=())))
    if back.grasp is not None:
        wait(body, CALM_S)
        open_fingers(body, back.grasp.opening_m)
    _follow(body, back.home, _Halt(stop, on_from, RetreatPath()))


def _without_it(
    body: RobotInterface, grasp: Grasp, home: tuple[Trajectory, ...], mark: Mark, stop: Stop
) -> ExecutionResult:
    """The block is lost: goes home high above the others and puts nothing down."""
    open_fingers(body, grasp.opening_m)
    _follow(body, home, _Halt(stop, on_from, RetreatPath()))
    mark("slipped")
    return ExecutionResult.SLIPPED


def _take_back(
    body: RobotInterface, carry: PickAndPlace, mark: Mark, stop: Stop
) -> ExecutionResult:
    """What was to be lowered has met something: puts it down where it was.

    Raises `StuckError` if it was no block that the joints have met.
    """
    away = RetreatPath(grasp=carry.grasp, home=(carry.lift, *carry.back))
    down = replace(away, ways=(Backwards(carry.lift),))
    up = back_along(body.joints(), carry.lower)
    ways = (*up, *(Backwards(way) for way in carry.transfer[::-1]))
    _follow(body, ways, _Halt(stop, on_from, down))
    try:
        _follow(body, down.ways, _Halt(stop, on_from, away), lag_rad=TOUCH_RAD)
    except StuckError:
        # What it has met may hang below it, and stands now.
        up = back_along(body.joints(), down.ways[0])
        away = replace(away, home=(*up, *carry.back))
    retreat(body, away, stop)
    mark("taken back")
    return ExecutionResult.TAKEN_BACK


@dataclass(frozen=True)
class _Halt:
    """When to stop, whether the way back begins with what is left or with what is behind it, and
    what follows then."""

    stop: Stop
    way_back: Callable[[Sequence[Trajectory], int, float, RetreatPath], RetreatPath]
    then: RetreatPath


def _follow(
    body: RobotInterface,
    ways: Sequence[Trajectory],
    halt: _Halt,
    least_m: float = 0.0,
    lag_rad: float = LAG_RAD,
) -> bool:
    """Along all of them; whether the fingers stayed as far open all the time.

    Raises `StuckError` if the joints are behind by more than `lag_rad`, `StoppedError` once they
    stand still because they were to stop.
    """
    holds = True
    for index, way in enumerate(ways):
        moments = _at_ticks(body, way)
        for tick, (joints, speeds) in enumerate(zip(moments.joints, moments.speeds, strict=True)):
            if halt.stop():
                braking = Braking(way, tick * body.tick_s)
                _brake(body, braking)
                raise StoppedError(halt.way_back(ways, index, braking.stopped_s, halt.then))
            body.drive(joints, speeds)
            body.tick()
            _check_lag(body, joints, lag_rad)
            holds &= body.opening_m() >= least_m
    if ways:
        _check_lag(body, ways[-1].end, ARRIVED_RAD)
    return holds


def _brake(body: RobotInterface, braking: Braking) -> None:
    moments = _at_ticks(body, braking)
    for joints, speeds in zip(moments.joints, moments.speeds, strict=True):
        body.drive(joints, speeds)
        body.tick()
        _check_lag(body, joints, LAG_RAD)


def _at_ticks(body: RobotInterface, way: Trajectory | Braking) -> Moments:
    """Of those to come; at the last one it is at rest, at or behind its end."""
    ticks = math.ceil(way.duration_s / body.tick_s)
    return way.at(np.linspace(body.tick_s, ticks * body.tick_s, ticks, dtype=np.float64))


def _check_lag(body: RobotInterface, told: Joints, most_rad: float) -> None:
    now = body.joints()
    lag_rad = float(np.abs(now - told).max())
    if lag_rad > most_rad:
        body.drive(now, np.zeros_like(now))
        raise StuckError(
            f"the arm's joints are {lag_rad:.3f} rad from where they were told to be; it stands "
            "still there with its fingers as they are"
        )
