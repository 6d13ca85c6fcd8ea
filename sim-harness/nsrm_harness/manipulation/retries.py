"""Reaches one sub-goal despite failures: executes a pick and place, observes, and retries a bounded
number of times. Blocks that are too close are moved aside first, and a block that needs another
grasp is set down on the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.displacements import Displacements, DisplacementTracker, in_words
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult, Mark, execute, unmarked
from nsrm_harness.manipulation.pick_and_place import PickAndPlace, PickAndPlacePlanner
from nsrm_harness.manipulation.regrasp import plan_regrasp
from nsrm_harness.manipulation.relocation import Relocation, plan_relocations
from nsrm_harness.manipulation.robot_interface import RobotInterface
from nsrm_harness.manipulation.stopping import Stop, never_stopped
from nsrm_harness.perception.cuboids import EDGE_M

MAX_TRIES = 3
PLACED_M = 0.005
"""Maximum distance between where a block was to be put and where it is seen afterwards."""
TURNED_RAD = math.radians(8.0)
"""Maximum rotation of a block that is seen whole: 5° count as successful, and an image of a block
that is partly covered but seems whole may be off by 3°. In 152 steps none was seen beyond 2.3°."""

Look = Callable[[], Mapping[str, Cuboid]]
"""Takes an image; returns all objects that are believed to be there, by name."""
Tell = Callable[[Sequence[str]], object]
"""Called with the names of the objects that are carried first, before they are: see
`SubGoalReached.cleared`."""


def untold(names: Sequence[str]) -> None:
    """Ignores the names."""


Ready = Callable[[Mapping[str, Cuboid]], None]
"""Called with what is seen right before the block itself is carried; may raise
`ManipulationError`."""


def always_ready(objects: Mapping[str, Cuboid]) -> None:
    """Raises nothing."""


class ManipulationError(HarnessError):
    """Something has moved, but not as intended; the arm is at rest in its ready pose.

    * `what`: what went wrong
    * `done`: how the last pick and place ended; None if no further one is possible as things stand
    * `why`: why it is impossible, in that case
    * `after`: how the pick and place before that ended, if there was one
    * `shifted`: displacements of other objects, over all tries
    """

    def __init__(
        self,
        what: str,
        done: ExecutionResult | None = None,
        why: RefusalReason | None = None,
        shifted: Displacements = (),
        after: ExecutionResult | None = None,
    ) -> None:
        super().__init__(what + in_words(shifted))
        self.what, self.done, self.why, self.shifted = what, done, why, shifted
        self.after = after


@dataclass(frozen=True)
class SubGoalReached:
    """How a sub-goal was reached, by what is seen afterwards.

    * `corrected_m`: distance between the model's sub-goal and where the block was meant to go
    * `miss_m`: distance between that and where it is
    * `shifted`: displacements of other objects, over all tries
    * `motion_s`: duration of the arm's motions, over all tries
    * `cleared`: what was moved aside before a try, or the block itself if it was set down on the
      way, and where it was put; `tries` does not count these
    """

    name: str
    tries: int
    corrected_m: float
    miss_m: float
    shifted: Displacements
    motion_s: float
    cleared: tuple[Relocation, ...] = ()

    @property
    def aside(self) -> list[Pose]:
        """Where other blocks were put beforehand, without the place where this one was set down on
        the way."""
        return [place for other, place in dict(self.cleared).items() if other != self.name]

    def __str__(self) -> str:
        text = (
            f"{self.name} is seen {1000 * self.miss_m:.1f} mm from where it was to go, which is "
            f"{1000 * self.corrected_m:.1f} mm from the model's sub-goal, after "
            f"{self.motion_s:.1f} s of motion"
        )
        if self.tries > 1:
            text += f"; at try {self.tries}"
        if self.cleared:
            text += f"; {_first(self.name, self.cleared)}"
        return text + in_words(self.shifted)

    def as_json(self) -> dict[str, Any]:
        """The same for programs; None as the displacement of an object that is no longer seen."""
        return {
            "tries": self.tries,
            "corrected_m": self.corrected_m,
            "miss_m": self.miss_m,
            "motion_s": self.motion_s,
            "shifted_m": {
                name: shift_m if math.isfinite(shift_m) else None for name, shift_m in self.shifted
            },
            "cleared": {
                name: {"position": pose.position, "orientation": pose.orientation}
                for name, pose in self.cleared
            },
        }


@dataclass(frozen=True)
class ExecutionOptions:
    """How a sub-goal is executed: the limits, and who is notified (MoveIt's
    `PlanExecution::Options`).

    * `tries`: maximum number of tries for each object that is carried; 1 or more
    * `keep`: names of the objects that are not moved aside
    * `stop`: whether to stop, called at each tick
    * `mark`: called with each event as it happens
    * `tell`: called with the names of the objects that are carried first
    * `ready`: called with what is seen right before the block itself is carried
    """

    tries: int = MAX_TRIES
    keep: Collection[str] = ()
    stop: Stop = never_stopped
    mark: Mark = unmarked
    tell: Tell = untold
    ready: Ready = always_ready

    def __post_init__(self) -> None:
        if self.tries < 1:
            raise ValueError(f"tries: expected 1 or more, got {self.tries}")


def reach_sub_goal(
    body: RobotInterface,
    planner: PickAndPlacePlanner,
    look: Look,
    name: str,
    goal: Pose,
    options: ExecutionOptions = ExecutionOptions(),
) -> SubGoalReached:
    """Carries a block to its sub-goal. Blocks that are too close are moved aside first, or the
    block itself is set down on the way.

    * `goal`: pose of the block's centre in the world, metres, upright

    Raises `RefusedError` if it is impossible as things stand, and nothing has moved;
    `ManipulationError` if it was tried and failed; `StuckError` and `StoppedError` as `execute`.
    """
    execution = _Execution(body, planner, look, options)

    def before(objects: Mapping[str, Cuboid], refusal: RefusedError) -> tuple[Relocation, ...]:
        begin = body.joints()
        return plan_relocations(
            planner, objects, name, goal, begin, refusal, options.keep
        ) or plan_regrasp(planner, objects, name, goal, begin, refusal)

    return execution.carry(execution.see(), name, goal, before, options.ready)


Before = Callable[[Mapping[str, Cuboid], RefusedError], tuple[Relocation, ...]]
"""What is carried first, so that a pick and place that was refused among these objects becomes
possible."""


def _nothing(*_: object) -> tuple[Relocation, ...]:
    return ()


@dataclass(frozen=True)
class _Execution:
    """One execution of a sub-goal: carries the block and what has to be moved first."""

    body: RobotInterface
    planner: PickAndPlacePlanner
    look: Look
    options: ExecutionOptions
    shifts: DisplacementTracker = field(default_factory=DisplacementTracker)

    def see(self, carried: str | None = None) -> Mapping[str, Cuboid]:
        """Observes; returns all objects that are believed to be there.

        * `carried`: the object that was to move since the previous observation
        """
        objects = self.look()
        self.shifts.see(objects, carried)
        return objects

    def carry(
        self,
        objects: Mapping[str, Cuboid],
        name: str,
        goal: Pose,
        before: Before = _nothing,
        ready: Ready = always_ready,
    ) -> SubGoalReached:
        """Carries a block to its sub-goal, and retries from each new observation; before each try,
        carries what has to be moved first. Raises as `reach_sub_goal`."""
        first: list[SubGoalReached] = []
        cleared: tuple[Relocation, ...] = ()
        motion_s = 0.0
        done = ExecutionResult.PLACED
        for number in range(1, self.options.tries + 1):
            ready(objects)
            try:
                carry = self.planner.carry(objects, name, goal, self.body.joints())
            except RefusedError as refusal:
                relocations = before(objects, refusal)
                if not relocations and number == 1:
                    raise
                if not relocations:
                    why = f"{name}: {done.value} at try {number - 1}, and now {refusal}"
                    failed = self._failed(name, cleared, why, why=refusal.why, after=done)
                    raise failed from None
                cleared += relocations
                first += self._clear(objects, name, relocations)
                objects = self.see()
                ready(objects)
                carry = self._carry_after(cleared, objects, name, goal)
            done = execute(self.body, carry, self.options.mark, self.options.stop)
            motion_s += carry.duration_s
            objects = self.see(name)
            target = carry.placement.cuboid.pose
            miss_m, turned_rad = float("inf"), 0.0
            if name in objects:
                miss_m = objects[name].pose.distance_m(target)
                turned_rad = seen_turned_rad(objects[name], carry.placement.cuboid)
            if done is ExecutionResult.PLACED and miss_m <= PLACED_M and turned_rad <= TURNED_RAD:
                return SubGoalReached(
                    name,
                    number,
                    carry.placement.corrected_m,
                    miss_m,
                    self.shifts.besides(name),
                    motion_s + sum(part.motion_s for part in first),
                    cleared,
                )
        where = (
            f"{1000 * miss_m:.0f} mm from where it was to go" if miss_m < 1 else "nowhere in sight"
        )
        if turned_rad > TURNED_RAD:
            where += f", turned by {math.degrees(turned_rad):.0f}°"
        times = "once" if self.options.tries == 1 else f"{self.options.tries} times"
        why = f"{name} was tried {times} and is {where} ({done.value}); giving up"
        raise self._failed(name, cleared, why, done)

    def _clear(
        self, objects: Mapping[str, Cuboid], name: str, relocations: tuple[Relocation, ...]
    ) -> list[SubGoalReached]:
        """Moves aside what prevents a block from being carried. Raises `ManipulationError`."""
        self.options.tell([blocker for blocker, _ in relocations])
        self.options.mark("clearing")
        done = []
        for blocker, place in relocations:
            try:
                done.append(self.carry(objects, blocker, place))
            except (RefusedError, ManipulationError) as error:
                what = (
                    f"{name} was to be set down on the way"
                    if blocker == name
                    else f"{blocker} stands in the way of {name} and was to be moved aside first"
                )
                how, last, after = str(error), None, None
                if isinstance(error, ManipulationError):
                    how, last, after = error.what, error.done, error.after
                failed = self._failed(name, (), f"{what}: {how}", last, error.why, after)
                raise failed from None
            objects = self.see()
        self.options.mark("cleared")
        return done

    def _carry_after(
        self, cleared: tuple[Relocation, ...], objects: Mapping[str, Cuboid], name: str, goal: Pose
    ) -> PickAndPlace:
        """Plans again what was refused before the last of these objects was moved. Raises
        `ManipulationError`."""
        try:
            return self.planner.carry(objects, name, goal, self.body.joints())
        except RefusedError as refusal:
            raise self._failed(name, cleared, str(refusal), why=refusal.why) from None

    def _failed(
        self,
        name: str,
        relocations: tuple[Relocation, ...],
        what: str,
        done: ExecutionResult | None = None,
        why: RefusalReason | None = None,
        after: ExecutionResult | None = None,
    ) -> ManipulationError:
        """The error: what was moved aside first, what went wrong then, and which other objects have
        moved."""
        what = f"{_first(name, relocations)}; then: {what}" if relocations else what
        return ManipulationError(what, done, why, self.shifts.besides(name), after)


def seen_turned_rad(seen: Cuboid, put: Cuboid) -> float:
    """How far a block is seen rotated from how it was to be put, up to rotations after which it
    looks the same: a quarter turn if an image cannot tell its edges apart, otherwise a half turn. 0
    if it is not seen whole, because its yaw is then that of a part of it.

    * `seen`: the cuboid that is believed to be there
    * `put`: the block where it was to be put, with the edges that it had
    """
    long, short = sorted(put.edges_m[:2], reverse=True)
    seen_long, seen_short = sorted(seen.edges_m[:2], reverse=True)
    if (seen_long, seen_short) == (long, short):
        # Equal to the last bit: they were not measured but kept, because a part of it is hidden.
        return 0.0
    if max(abs(seen_long - long), abs(seen_short - short)) > EDGE_M:
        return 0.0
    turn_rad, same_rad = _long_yaw_rad(seen) - _long_yaw_rad(put), math.pi
    if long - short <= 2 * EDGE_M:
        same_rad = math.pi / 2
    return abs((turn_rad + same_rad / 2) % same_rad - same_rad / 2)


def _long_yaw_rad(cuboid: Cuboid) -> float:
    """The direction of its longer edge."""
    a, b, _ = cuboid.edges_m
    return cuboid.pose.yaw_rad() + (math.pi / 2 if b > a else 0.0)


def _first(name: str, relocations: tuple[Relocation, ...]) -> str:
    """What was done before a block was carried to its sub-goal, in words."""
    names = list(dict(relocations))
    if names == [name]:
        return f"{name} was set down on the way, to be regrasped"
    return f"{' and '.join(names)} {'was' if len(names) == 1 else 'were'} moved aside first"
