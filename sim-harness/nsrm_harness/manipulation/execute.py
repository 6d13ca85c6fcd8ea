"""Executes a planned pick and place tick by tick, and monitors the joints' lag and the finger
opening, which shows whether the block is held."""

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
    back_from,
    never_stopped,
    on_from,
    reversed_from,
)
from nsrm_harness.manipulation.trajectory import Backwards, Moments, Trajectory

WIDTH_M = 0.004
"""Tolerance between finger opening and block width for a block to count as held."""
SLIP_M = 0.002
"""A block counts as lost if the fingers close further by more than this."""
CALM_S = 0.1
"""Pause before the fingers open, so that nothing swings."""
LAG_RAD = 0.02
"""Maximum lag of joints that follow: at full speed, 2.6 rad/s, it corresponds to 8 ms."""
TOUCH_RAD = 0.0025
"""Maximum lag while the hand or a block is lowered slowly. Without contact, the lag is 0.001; more
than this means contact before it was expected."""
ARRIVED_RAD = 0.002
"""Maximum lag at the end of a motion after which the fingers move. Not checked between two motions:
an obstacle that was met may keep pushing for a while."""


Mark = Callable[[str], None]
"""Called with the name of each event as it happens."""


def unmarked(event: str) -> None:
    """Ignores all events."""


class ExecutionResult(Enum):
    """How a pick and place ended, as far as the fingers can tell."""

    PLACED = "placed"
    NOT_GRASPED = "not grasped"
    SLIPPED = "slipped"
    PUT_BACK = "put back where it was, as something is in the way"


def execute(
    body: RobotInterface, carry: PickAndPlace, mark: Mark = unmarked, stop: Stop = never_stopped
) -> ExecutionResult:
    """Executes a planned pick and place, and ends in the ready pose whatever happens to the block.

    Bounded: motions by their durations, the fingers as in `open_fingers`. Raises `StuckError`, or
    `GripperError` for the fingers, and `StoppedError` if it was told to stop.
    """
    grasp = carry.grasp
    # Before the arm moves: the path was checked with the fingers this far open.
    begin = carry.reach[0].begin
    body.drive(begin, np.zeros_like(begin))
    open_fingers(body, grasp.opening_m)
    _follow(body, carry.reach, _Halt(stop, back_from, RetreatPath()))
    from_here = RetreatPath(trajectories=tuple(Backwards(each) for each in carry.reach[::-1]))
    try:
        _follow(body, [carry.descend], _Halt(stop, back_from, from_here), lag_rad=TOUCH_RAD)
    except StuckError:
        up = reversed_from(body.joints(), carry.descend)
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
    down = replace(away, trajectories=(Backwards(carry.lift),))
    if not _follow(body, carry.transfer, _Halt(stop, back_from, down), least_m):
        return _without_it(body, grasp, carry.home, mark, stop)
    mark("above")
    back = tuple(Backwards(each) for each in carry.transfer[::-1])
    over = replace(down, trajectories=(*back, *down.trajectories))
    try:
        holds = _follow(body, [carry.lower], _Halt(stop, back_from, over), least_m, TOUCH_RAD)
    except StuckError:
        return _put_back(body, carry, mark, stop)
    wait(body, CALM_S)
    open_fingers(body, grasp.opening_m)
    mark("let go")
    _follow(body, (carry.retreat, *carry.home), _Halt(stop, on_from, RetreatPath()))
    mark("home")
    return ExecutionResult.PLACED if holds else ExecutionResult.SLIPPED


def retreat(body: RobotInterface, back: RetreatPath, stop: Stop = never_stopped) -> None:
    """Puts a held block down where it was picked up, and moves the arm back to where it started.

    Raises `StuckError` and `StoppedError`, as `execute`.
    """
    _follow(body, back.trajectories, _Halt(stop, on_from, replace(back, trajectories=())))
    if back.grasp is not None:
        wait(body, CALM_S)
        open_fingers(body, back.grasp.opening_m)
    _follow(body, back.home, _Halt(stop, on_from, RetreatPath()))


def _without_it(
    body: RobotInterface, grasp: Grasp, home: tuple[Trajectory, ...], mark: Mark, stop: Stop
) -> ExecutionResult:
    """After the block is lost: moves home high above the others and puts nothing down."""
    open_fingers(body, grasp.opening_m)
    _follow(body, home, _Halt(stop, on_from, RetreatPath()))
    mark("slipped")
    return ExecutionResult.SLIPPED


def _put_back(body: RobotInterface, carry: PickAndPlace, mark: Mark, stop: Stop) -> ExecutionResult:
    """After contact while lowering: puts the block back where it was picked up.

    Raises `StuckError` if what the joints have met was not a block.
    """
    away = RetreatPath(grasp=carry.grasp, home=(carry.lift, *carry.back))
    down = replace(away, trajectories=(Backwards(carry.lift),))
    up = reversed_from(body.joints(), carry.lower)
    trajectories = (*up, *(Backwards(each) for each in carry.transfer[::-1]))
    _follow(body, trajectories, _Halt(stop, on_from, down))
    try:
        _follow(body, down.trajectories, _Halt(stop, on_from, away), lag_rad=TOUCH_RAD)
    except StuckError:
        # What the block met may hang below it, and has touched down now.
        up = reversed_from(body.joints(), down.trajectories[0])
        away = replace(away, home=(*up, *carry.back))
    retreat(body, away, stop)
    mark("put back")
    return ExecutionResult.PUT_BACK


@dataclass(frozen=True)
class _Halt:
    """When to stop, whether the retreat continues along the rest of the motion or goes back along
    what was done, and what follows then."""

    stop: Stop
    retreat_from: Callable[[Sequence[Trajectory], int, float, RetreatPath], RetreatPath]
    then: RetreatPath


def _follow(
    body: RobotInterface,
    trajectories: Sequence[Trajectory],
    halt: _Halt,
    least_m: float = 0.0,
    lag_rad: float = LAG_RAD,
) -> bool:
    """Follows all trajectories; true if the fingers never closed below `least_m`.

    Raises `StuckError` if the joints lag by more than `lag_rad`, and `StoppedError` once they have
    come to rest after a stop.
    """
    holds = True
    for index, trajectory in enumerate(trajectories):
        moments = _at_ticks(body, trajectory)
        for tick, (joints, speeds) in enumerate(zip(moments.joints, moments.speeds, strict=True)):
            if halt.stop():
                braking = Braking(trajectory, tick * body.tick_s)
                _brake(body, braking)
                raise StoppedError(
                    halt.retreat_from(trajectories, index, braking.stopped_s, halt.then)
                )
            body.drive(joints, speeds)
            body.tick()
            _check_lag(body, joints, lag_rad)
            holds &= body.opening_m() >= least_m
    if trajectories:
        _check_lag(body, trajectories[-1].end, ARRIVED_RAD)
    return holds


def _brake(body: RobotInterface, braking: Braking) -> None:
    moments = _at_ticks(body, braking)
    for joints, speeds in zip(moments.joints, moments.speeds, strict=True):
        body.drive(joints, speeds)
        body.tick()
        _check_lag(body, joints, LAG_RAD)


def _at_ticks(body: RobotInterface, trajectory: Trajectory | Braking) -> Moments:
    """The trajectory's states at the ticks to come; the last tick is at or after its end, where it
    is at rest."""
    ticks = math.ceil(trajectory.duration_s / body.tick_s)
    return trajectory.at(np.linspace(body.tick_s, ticks * body.tick_s, ticks, dtype=np.float64))


def _check_lag(body: RobotInterface, told: Joints, most_rad: float) -> None:
    now = body.joints()
    # At each tick: numpy's abs and max take three times as long for so few numbers.
    lag_rad = max(map(abs, (now - told).tolist()))
    if lag_rad > most_rad:
        body.drive(now, np.zeros_like(now))
        raise StuckError(
            f"the arm's joints are {lag_rad:.3f} rad from where they were told to be; it stands "
            "still there with its fingers as they are"
        )
