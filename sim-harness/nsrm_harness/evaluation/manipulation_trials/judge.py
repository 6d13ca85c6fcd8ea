"""What the truth of the simulator says of a step that the arm has carried out. Nothing of this
reaches the arm."""

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
"""A step is done as said when the block is so near to the true relation, so little turned, and
nothing else has moved farther."""
NEAR_M = 0.005
"""What a block stands on it may touch in the hand so near to where it was grasped or let go."""
APART_TICKS = 50
"""Fingers that were off a block for longer hold it anew."""


@dataclass(frozen=True)
class PlacementVerdict:
    """How a step went.

    * `off_m`, `off_rad`: from the true relation to its reference: see `PlacementJudge.end`
    * `shift_m`: the farthest that another block was moved
    * `at_rest`: all blocks, at its end
    * `touched`: what the arm or the block in its hand pushed against, and should not have
    * `seconds`: simulated
    * `step`: which one of the sentence it was, counted from 0
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
        """Done, whatever else has moved."""
        return self.off_m <= POSITION_M and self.off_rad <= YAW_RAD and self.at_rest

    @property
    def is_as_said(self) -> bool:
        """Done, and nothing else."""
        return self.is_in_place and self.shift_m <= SHIFT_M

    def __str__(self) -> str:
        text = (
            f"{1000 * self.off_m:.1f} mm and {math.degrees(self.off_rad):.1f}° from the true "
            f"relation; others moved {1000 * self.shift_m:.1f} mm at most"
        )
        return text if self.at_rest else f"{text}; not at rest"


@dataclass
class _Hold:
    """A block between the fingers.

    * `begin`, `end`: where it was so first and last, in tick `tick`
    * `met`: what it pushed against away from `begin`, and where
    """

    number: int
    begin: Pose
    end: Pose
    tick: int
    met: list[tuple[Contact, Pose]] = field(default_factory=list)

    @property
    def on_the_way(self) -> set[Contact]:
        """What it pushed against elsewhere than where it was grasped or let go."""
        return {contact for contact, pose in self.met if pose.distance_m(self.end) > NEAR_M}


class PlacementJudge:
    """Watches a world while its arm carries steps out.

    * `blocks`: of the world, by index: the id without one
    """

    def __init__(self, world: ArmWorld, blocks: Sequence[Block]) -> None:
        self._world, self._blocks = world, blocks
        self._has_begun = False

    def begin(self, move: Move) -> Pose:
        """A step begins; gives where its block is to be."""
        self._has_begun = True
        self._move, self._before, self._ticks = move, self._poses(), 0
        self._seen: set[Contact] = set()
        self._holds: list[_Hold] = []
        self._held: set[int] = set()
        self._stood = self._standing()
        self._target = target(move, self._blocks, self._before)
        return self._target

    def tick(self) -> None:
        """To be called in each tick of the arm; before the first step nothing is watched."""
        if not self._has_begun:
            return
        self._ticks += 1
        now = self._world.contacts(*{self._move.moved + 1, *self._held})
        self._seen |= now
        self._held = _between_fingers(now)
        for number in self._held:
            self._hold(number, now)

    def end(self, aside: Sequence[Pose] = (), *, anew: bool = False) -> PlacementVerdict:
        """The step has ended.

        * `aside`: where other blocks were put that it was said of that they are moved
        * `anew`: the block is to be where its reference is now; otherwise, where that stood
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
        # What they stood on, and stand on now.
        rightly = {it for it in self._stood | self._standing() if carried & set(it)}
        on_the_way = {it for hold in self._holds for it in hold.on_the_way}
        touched = sorted(
            str(it)
            for it in (self._seen - rightly) | on_the_way
            if not set(it) & set(panda.FINGERS) or not set(it) & carried
        )
        there = target(self._move, self._blocks, after) if anew else self._target
        return PlacementVerdict(
            after[moved].distance_m(there),
            turned_rad(after[moved], there),
            max(shifts, default=0.0),
            self._world.slow(),
            tuple(touched),
            self._ticks * self._world.tick_s,
        )

    def stands(self, moves: Sequence[Move]) -> bool:
        """Whether all these blocks are at the end where their moves have them be, by where their
        references are now."""
        poses = self._poses()
        wanted = [(poses[move.moved], target(move, self._blocks, poses)) for move in moves]
        return all(
            pose.distance_m(there) <= POSITION_M and turned_rad(pose, there) <= YAW_RAD
            for pose, there in wanted
        )

    def _hold(self, number: int, now: set[Contact]) -> None:
        """A block is between the fingers in this tick, and these push against each other."""
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
        """What all blocks stand on now, or lean against."""
        numbers = range(1, len(self._blocks) + 1)
        standing = {TABLE, *numbers}
        return {it for it in self._world.contacts(*numbers) if standing.issuperset(it)}

    def _poses(self) -> list[Pose]:
        return [placed.pose for placed in self._world.placed()]


def _between_fingers(contacts: set[Contact]) -> set[int]:
    """The numbers of the blocks that both fingers push against."""
    by_finger = [
        {one for it in contacts if finger in it for one in it if isinstance(one, int)}
        for finger in panda.FINGERS
    ]
    return set.intersection(*by_finger)


def turned_rad(one: Pose, other: Pose) -> float:
    """Between the yaws of two blocks, which look the same after a quarter of a turn."""
    yaw = one.yaw_rad() - other.yaw_rad()
    return abs((yaw + math.pi / 4) % (math.pi / 2) - math.pi / 4)
