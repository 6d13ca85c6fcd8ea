"""Plans the pick and place of a block, from where it is seen to its sub-goal: all motions are
planned and checked before the first one starts."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.collision import HELD, CollisionChecker, Nearest
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.grasps import HOLDS, LEANS_RAD, UPRIGHT, Grasp, grasps, why_not_held
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.manipulation.paths import free, line, turned_rad
from nsrm_harness.manipulation.stability import Placement, placement, resting_on, standing_on
from nsrm_harness.manipulation.trajectory import Along, Straight, Trajectory

PACE = 0.8
"""Fraction of the maker's limits of speed, acceleration and jerk."""
RISE_M = 0.08
"""Height of the vertical approach and retreat, above the hand's poses at grasp and release."""
DROP_M = 0.0005
"""Height above its support at which a block is released."""
SQUARE_M = 0.002
"""A block counts as square if its edges differ by no more than this."""
MAX_TURN_RAD = math.radians(120.0)
"""Maximum rotation of a held block on its path. No sub-goal needs more than 90°, and paths around
an obstacle need somewhat more; some joint solutions take the long way round, 270°
(docs/decisions/arm.md)."""


@dataclass(frozen=True, eq=False)
class PickAndPlace:
    """A planned pick and place, in the order in which it is executed.

    * the fingers open as far as the grasp says; `reach`: to above the block
    * `descend`; then the fingers close; `lift`
    * `transfer`: to above the block's new place
    * `lower`; then the fingers open; `retreat`
    * `home`: to the ready pose, out of the camera's view
    * `back`: to the ready pose from above the block, if the grasp failed
    """

    grasp: Grasp
    placement: Placement
    reach: tuple[Trajectory, ...]
    descend: Trajectory
    lift: Trajectory
    transfer: tuple[Trajectory, ...]
    lower: Trajectory
    retreat: Trajectory
    home: tuple[Trajectory, ...]
    back: tuple[Trajectory, ...]

    @property
    def duration_s(self) -> float:
        """The duration of all motions; the fingers need additional time."""
        parts = (*self.reach, self.descend, self.lift, *self.transfer, self.lower, self.retreat)
        return sum(part.duration_s for part in (*parts, *self.home))


@dataclass(frozen=True, eq=False)
class _Task:
    """What all grasps of a block have in common.

    * `put`: the block's target placement, in one of the rotations after which it looks the same
    * `before`, `after`: collision checkers for the fingers about the block, which they may touch,
      where it stands and where it is put
    """

    name: str
    block: Cuboid
    others: Mapping[str, Cuboid]
    begin: Joints
    put: Placement
    before: CollisionChecker
    after: CollisionChecker

    def held_by(self, grasp: Grasp) -> tuple[Cuboid, Pose]:
        """The block in the hand's frame, and the hand's pose at release."""
        in_hand = Cuboid(grasp.hand.inverse() @ self.block.pose, self.block.edges_m)
        return in_hand, _above(self.put.cuboid.pose @ in_hand.pose.inverse(), DROP_M)


@dataclass(frozen=True, eq=False)
class _VerticalMotions:
    """The vertical motions with one grasp; see `PickAndPlace`."""

    descend: Along
    lift: Along
    lower: Along
    retreat: Along


class _OutOfReach(Enum):
    """At which end the arm cannot lift the hand straight up with a grasp."""

    BLOCK = "block"
    GOAL = "sub-goal"


@dataclass(frozen=True)
class _TurnsTooFar:
    """All motions up to the release are free, but they would rotate the block too far.

    * `around`: what it would touch on the straight path, if anything
    """

    turn_rad: float
    around: Nearest | None

    def __str__(self) -> str:
        text = (
            f"the path there turns it by {math.degrees(self.turn_rad):.0f}°, and "
            f"{math.degrees(MAX_TURN_RAD):.0f}° are allowed"
        )
        return text if self.around is None else f"{text}; straight there, {self.around}"


class _Failed(NamedTuple):
    """A grasp that does not work, and why."""

    grasp: Grasp
    task: _Task
    why: Nearest | _TurnsTooFar | _OutOfReach


class PickAndPlacePlanner:
    """Plans pick and place. Not thread-safe: use one for each thread.

    * `alive`: called every few milliseconds during planning, which may take seconds
    """

    def __init__(self, pace: float = PACE, alive: Callable[[], None] = lambda: None) -> None:
        self._kinematics, self._pace, self._alive = Kinematics(), pace, alive
        # Loads the arm's hulls now rather than during the first plan.
        self._checker({})

    def carry(
        self,
        objects: Mapping[str, Cuboid],
        name: str,
        goal: Pose,
        begin: Joints,
        *,
        leaning: bool = True,
    ) -> PickAndPlace:
        """Plans the pick and place of a block to its sub-goal.

        * `objects`: all objects that are seen, by name
        * `goal`: pose of the block's centre, upright
        * `begin`: the current joints
        * `leaning`: whether tilted hands are tried too, which takes five times as long if nothing
          is found

        Raises `RefusedError`.
        """
        if name not in objects:
            raise RefusedError(RefusalReason.UNSEEN, f"{name} is not seen")
        block = objects[name]
        others = {key: cuboid for key, cuboid in objects.items() if key != name}
        if on_it := resting_on(block, others):
            raise RefusedError(
                RefusalReason.COVERED,
                f"{' and '.join(on_it)} stands on {name}: move it first",
                tuple(on_it),
            )
        if why := why_not_held(block):
            raise RefusedError(RefusalReason.NO_GRASP, f"the hand cannot hold {name}: {why}")
        try:
            put = placement(goal, block, others)
        except RefusedError as refusal:
            raise RefusedError(
                refusal.why, f"{name} cannot stand there: {refusal}", refusal.in_the_way
            ) from None
        before = self._checker(objects, ignored=_fingers_and(name))
        tasks = [
            _Task(
                name,
                block,
                others,
                begin,
                replace(put, cuboid=there),
                before,
                self._checker({**others, name: there}, ignored=_fingers_and(name)),
            )
            for there in _looking_the_same(put.cuboid, block)
        ]
        failed: list[_Failed] = []
        leans_rad = LEANS_RAD if leaning else UPRIGHT
        for places, clear_m in HOLDS:
            candidates = _least_turns_first(grasps(block, leans_rad, places, clear_m))
            for task, grasp in itertools.product(tasks, candidates):
                found = self._by(grasp, task)
                if isinstance(found, PickAndPlace):
                    return found
                failed.append(_Failed(grasp, task, found))
        raise self._refusal(name, others, failed)

    def _by(self, grasp: Grasp, task: _Task) -> PickAndPlace | Nearest | _TurnsTooFar | _OutOfReach:
        """Plans all motions with one grasp; returns the reason if that is impossible."""
        self._alive()
        lines = self._lines(grasp, task)
        if not isinstance(lines, _VerticalMotions):
            return lines
        return self._between(lines, grasp, task)

    def _lines(self, grasp: Grasp, task: _Task) -> _VerticalMotions | Nearest | _OutOfReach:
        """Plans the vertical motions with one grasp; returns the reason if that is impossible."""
        opening_m, held_m = grasp.opening_m, grasp.width_m
        in_hand, let_go = task.held_by(grasp)
        # Most grasps fail where the fingers are about to close, or have just opened.
        touch = self._touch(task.before, grasp.hand, task.begin, opening_m)
        if touch is not None:
            return touch
        lift = self._up_from(grasp.hand, task.begin)
        if lift is None:
            return _OutOfReach.BLOCK
        touch = self._touch(task.after, let_go, lift.end, opening_m)
        if touch is not None:
            return touch
        retreat = self._up_from(let_go, lift.end)
        if retreat is None:
            return _OutOfReach.GOAL
        lines = _VerticalMotions(lift.reversed(), lift, retreat.reversed(), retreat)
        standing = [(HELD, support) for support in standing_on(task.block, task.others)]
        put = [(HELD, support) for support in task.put.support]
        for checker, trajectory, fingers_m in (
            (task.before, lines.descend, opening_m),
            (self._checker(task.others, in_hand, standing), lines.lift, held_m),
            (self._checker(task.others, in_hand, put), lines.lower, held_m),
            (task.after, lines.retreat, opening_m),
        ):
            touch = checker.along(trajectory, fingers_m)
            if touch is not None:
                return touch
        return lines

    def _between(
        self, lines: _VerticalMotions, grasp: Grasp, task: _Task
    ) -> PickAndPlace | Nearest | _TurnsTooFar:
        """Plans the motions to, between and after the vertical ones; returns the reason if that is
        impossible."""
        opening_m, held_m, pace = grasp.opening_m, grasp.width_m, self._pace
        above_block, above_goal = lines.lift.end, lines.lower.begin
        # Here the fingers must not touch the block either.
        before = self._checker({**task.others, task.name: task.block})
        after = self._checker({**task.others, task.name: task.put.cuboid})
        reach = free(before, task.begin, lines.descend.begin, opening_m, pace)
        if isinstance(reach, Nearest):
            return reach
        carrying = self._checker(task.others, task.held_by(grasp)[0])
        transfer = free(carrying, above_block, above_goal, held_m, pace)
        if isinstance(transfer, Nearest):
            return transfer
        turn_rad = turned_rad(self._kinematics, transfer)
        if turn_rad > MAX_TURN_RAD:
            straight = Straight(above_block, above_goal, pace)
            return _TurnsTooFar(turn_rad, carrying.along(straight, held_m))
        home = free(after, lines.retreat.end, panda.READY_RAD, opening_m, pace)
        if isinstance(home, Nearest):
            return home
        back = free(before, above_block, panda.READY_RAD, opening_m, pace)
        if isinstance(back, Nearest):
            return back
        return PickAndPlace(
            grasp,
            task.put,
            tuple(reach),
            lines.descend,
            lines.lift,
            tuple(transfer),
            lines.lower,
            lines.retreat,
            tuple(home),
            tuple(back),
        )

    def _refusal(
        self, name: str, others: Mapping[str, Cuboid], failed: Sequence[_Failed]
    ) -> RefusedError:
        """Why no grasp of a block works, by the one that comes closest to working: one that only
        rotates the block too far touches nothing, and one that touches something is within
        reach."""
        turns = [each.why for each in failed if isinstance(each.why, _TurnsTooFar)]
        turns.sort(key=lambda turn: turn.turn_rad)
        touches = [each.why for each in failed if isinstance(each.why, Nearest)]
        touches.sort(key=lambda touch: touch.distance_m, reverse=True)
        if turns or touches:
            around = [turn.around for turn in turns if turn.around is not None]
            # Without duplicates, in the order in which they occur.
            touched = dict.fromkeys(
                key for touch in (*around, *touches) for key in sorted(touch.pair)
            )
            return RefusedError(
                RefusalReason.NO_PATH,
                f"{name} cannot be carried there: {turns[0] if turns else touches[0]}",
                tuple(key for key in touched if key in others),
            )
        if all(each.why is _OutOfReach.BLOCK for each in failed):
            return RefusedError(
                RefusalReason.OUT_OF_REACH,
                f"the arm does not reach {name} from above: move it nearer",
            )
        elsewhere = (each for each in failed if each.why is _OutOfReach.BLOCK)
        if any(self._up_from(task.held_by(grasp)[1], task.begin) for grasp, task, _ in elsewhere):
            return RefusedError(
                RefusalReason.NO_PATH,
                f"{name} cannot be carried there: no grasp reaches both where it stands "
                "and where it goes",
            )
        return RefusedError(
            RefusalReason.OUT_OF_REACH, f"the arm does not reach the sub-goal of {name} from above"
        )

    def _up_from(self, hand: Pose, near: Joints) -> Along | None:
        """The vertical line of the hand upwards from this pose; None if the arm cannot follow
        it."""
        return line(self._kinematics, hand, _above(hand, RISE_M), near, self._pace)

    def _touch(
        self, checker: CollisionChecker, hand: Pose, near: Joints, opening_m: float
    ) -> Nearest | None:
        """What is touched with the hand at this pose; None also if the pose is out of reach."""
        joints = self._kinematics.joints(hand, near)
        return None if joints is None else checker.touches(joints, opening_m)

    def _checker(
        self,
        objects: Mapping[str, Cuboid],
        held: Cuboid | None = None,
        ignored: Iterable[tuple[str, str]] = (),
    ) -> CollisionChecker:
        return CollisionChecker(self._kinematics, objects, held, ignored, self._alive)


def _fingers_and(name: str) -> list[tuple[str, str]]:
    """The pairs that may touch while a block is grasped or released."""
    return [(finger, name) for finger in panda.FINGERS]


def _above(hand: Pose, rise_m: float) -> Pose:
    x, y, z = hand.position
    return replace(hand, position=(x, y, z + rise_m))


def _looking_the_same(put: Cuboid, block: Cuboid) -> list[Cuboid]:
    """The block at its target, in rotations after which it looks the same: rotated as little from
    how it stands as possible, and a quarter turn more or less if it is square. Contacts that rotate
    with the hand hold better the less they rotate."""
    turn = put.pose.yaw_rad() - block.pose.yaw_rad()
    turn = (turn + math.pi / 2) % math.pi - math.pi / 2
    turns = [turn]
    if abs(block.edges_m[0] - block.edges_m[1]) <= SQUARE_M:
        turns += [turn - math.pi / 2, turn + math.pi / 2]
    turns.sort(key=abs)
    return [
        Cuboid(Pose.upright(*put.pose.position, block.pose.yaw_rad() + turn), put.edges_m)
        for turn in turns[:2]
    ]


def _least_turns_first(found: Sequence[Grasp]) -> list[Grasp]:
    """Sorts grasps: upright ones first, then low ones, then those that rotate the hand least from
    its ready pose."""

    def order(grasp: Grasp) -> tuple[float, float, float]:
        # The direction in which the fingers close.
        x, y, _ = grasp.hand.rotation()[:, 1]
        turn_rad = math.atan2(x, -y)
        return abs(grasp.lean_rad), grasp.hand.position[2], round(abs(turn_rad), 6)

    return sorted(found, key=order)
