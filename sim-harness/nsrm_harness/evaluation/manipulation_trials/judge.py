"""Judges the steps of the arm by the simulator's ground truth, none of which reaches the arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from nsrm_harness.data.moves import Move, target
from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.arm_world import TABLE, ArmWorld, Contact
from nsrm_harness.simulation.blocks import Block

POSITION_M, YAW_RAD, SHIFT_M = 0.005, math.radians(5.0), 0.003
"""A step succeeds if the block is within this distance and angle of the true relation, and no other
block moved by more than `SHIFT_M`."""
NEAR_M = 0.005
"""A held block may touch its support within this distance of where it was grasped or released."""
APART_TICKS = 50
"""Fingers that lose a block for longer than this start a new hold."""


@dataclass(frozen=True)
class PlacementVerdict:
    """The verdict on one step.

    * `off_m`, `off_rad`: deviation from the true relation, see `PlacementJudge.end`
    * `shift_m`: largest distance that another block was moved
    * `at_rest`: whether all blocks are at rest at its end
    * `touched`: unexpected contacts of the arm or of the block in its hand
    * `seconds`: simulated time
    * `step`: index of the step in the sentence, from 0
    """

    off_m: float
    off_rad: float
    shift_m: float
    at_rest: bool
    touched: tuple[str, ...]
    seconds: float
    step: int = 0

    @property
    def is_in_place(self) -> bool:
        """Whether the block is in place, whatever else has moved."""
        return self.off_m <= POSITION_M and self.off_rad <= YAW_RAD and self.at_rest

    @property
    def is_as_said(self) -> bool:
        """Whether the step succeeded: the block is in place and no other block has moved."""
        return self.is_in_place and self.shift_m <= SHIFT_M

    def __str__(self) -> str:
        text = (
            f"{1000 * self.off_m:.1f} mm and {math.degrees(self.off_rad):.1f}° from the true "
            f"relation; others moved {1000 * self.shift_m:.1f} mm at most"
        )
        return text if self.at_rest else f"{text}; not at rest"


@dataclass
class _Hold:
    """A period in which a block was between the fingers.

    * `begin`, `end`: its first and last pose there, the last in tick `tick`
    * `met`: its contacts away from `begin`, and its pose at each
    """

    number: int
    begin: Pose
    end: Pose
    tick: int
    met: list[tuple[Contact, Pose]] = field(default_factory=list)

    @property
    def on_the_way(self) -> set[Contact]:
        """Its contacts away from where it was grasped and released."""
        return {contact for contact, pose in self.met if pose.distance_m(self.end) > NEAR_M}


class PlacementJudge:
    """Watches a world while its arm executes steps.

    * `blocks`: blocks of the world, by index, which is the id minus one
    """

    def __init__(self, world: ArmWorld, blocks: Sequence[Block]) -> None:
        self._world, self._blocks = world, blocks
        self._has_begun = False

    def begin(self, move: Move) -> Pose:
        """Begins a step; returns the target of its block."""
        self._has_begun = True
        self._move, self._before, self._ticks = move, self._poses(), 0
        self._seen: set[Contact] = set()
        self._holds: list[_Hold] = []
        self._held: set[int] = set()
        self._stood = self._standing()
        self._target = target(move, self._blocks, self._before)
        return self._target

    def tick(self) -> None:
        """Call this in each tick of the arm. Before the first step it does nothing."""
        if not self._has_begun:
            return
        self._ticks += 1
        now = self._world.contacts(*{self._move.moved + 1, *self._held})
        self._seen |= now
        self._held = _between_fingers(now)
        for number in self._held:
            self._hold(number, now)

    def end(
        self, aside: Sequence[Pose] = (), *, by_current_reference: bool = False
    ) -> PlacementVerdict:
        """Ends the step and returns its verdict.

        * `aside`: the poses of other blocks that were reported as moved aside
        * `by_current_reference`: judge by where the reference is now; otherwise by where it was
          before the step
        """
        moved, after = self._move.moved, self._poses()
        put = {moved, *(self._world.nearest(pose.position)[0] - 1 for pose in aside)}
        shifts = (
            pose.distance_m(self._before[index])
            for index, pose in enumerate(after)
            if index not in put
        )
        carried = {index + 1 for index in put}
        # Supports before and after the step.
        rightly = {it for it in self._stood | self._standing() if carried & set(it)}
        on_the_way = {it for hold in self._holds for it in hold.on_the_way}
        touched = sorted(
            str(it)
            for it in (self._seen - rightly) | on_the_way
            if not set(it) & set(panda.FINGERS) or not set(it) & carried
        )
        there = target(self._move, self._blocks, after) if by_current_reference else self._target
        return PlacementVerdict(
            after[moved].distance_m(there),
            turned_rad(after[moved], there),
            max(shifts, default=0.0),
            self._world.slow(),
            tuple(touched),
            self._ticks * self._world.tick_s,
        )

    def stands(self, moves: Sequence[Move]) -> bool:
        """Whether all these moves hold at the end, relative to where their references are now."""
        poses = self._poses()
        wanted = [(poses[move.moved], target(move, self._blocks, poses)) for move in moves]
        return all(
            pose.distance_m(there) <= POSITION_M and turned_rad(pose, there) <= YAW_RAD
            for pose, there in wanted
        )

    def _hold(self, number: int, now: set[Contact]) -> None:
        """Records that a block is between the fingers in this tick, with these contacts."""
        pose = self._world.pose(number)
        before = (hold for hold in reversed(self._holds) if hold.number == number)
        hold = next(before, None)
        if hold is None or self._ticks - hold.tick > APART_TICKS:
            hold = _Hold(number, pose, pose, self._ticks)
            self._holds.append(hold)
        hold.end, hold.tick = pose, self._ticks
        if pose.distance_m(hold.begin) > NEAR_M:
            others = (it for it in now if number in it and not set(it) & set(panda.FINGERS))
            hold.met.extend((it, pose) for it in others)

    def _standing(self) -> set[Contact]:
        """The contacts of all blocks with what they stand on or lean against."""
        numbers = range(1, len(self._blocks) + 1)
        standing = {TABLE, *numbers}
        return {it for it in self._world.contacts(*numbers) if standing.issuperset(it)}

    def _poses(self) -> list[Pose]:
        return [placed.pose for placed in self._world.placed()]


def _between_fingers(contacts: set[Contact]) -> set[int]:
    """The numbers of the blocks in contact with both fingers."""
    by_finger = [
        {one for it in contacts if finger in it for one in it if isinstance(one, int)}
        for finger in panda.FINGERS
    ]
    return set.intersection(*by_finger)


def turned_rad(one: Pose, other: Pose) -> float:
    """Angle between the yaws of two blocks, which look the same after a quarter turn."""
    yaw = one.yaw_rad() - other.yaw_rad()
    return abs((yaw + math.pi / 4) % (math.pi / 2) - math.pi / 4)
