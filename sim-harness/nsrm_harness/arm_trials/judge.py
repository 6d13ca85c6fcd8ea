"""What the truth of the simulator says of a step that the arm has carried out. Nothing of this
reaches the arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from nsrm_harness.arm import panda
from nsrm_harness.episodes.moves import Move, target
from nsrm_harness.world.arm_world import ArmWorld, Contact
from nsrm_harness.world.blocks import Block
from nsrm_harness.world.pose import Pose

POSITION_M, YAW_RAD, SHIFT_M = 0.005, math.radians(5.0), 0.003
"""A step is done as said when the block is so near to the true relation, so little turned, and
nothing else has moved farther."""


@dataclass(frozen=True)
class Verdict:
    """How a step went.

    * `off_m`, `off_rad`: from the true relation to its reference as that stood before the step
    * `shift_m`: the farthest that another block was moved
    * `at_rest`: all blocks, at its end
    * `touched`: what the arm or the block in its hand pushed against, and should not have
    * `seconds`: simulated
    """

    off_m: float
    off_rad: float
    shift_m: float
    at_rest: bool
    touched: tuple[str, ...]
    seconds: float

    @property
    def is_as_said(self) -> bool:
        """Done, and nothing else."""
        return (
            self.off_m <= POSITION_M
            and self.off_rad <= YAW_RAD
            and self.shift_m <= SHIFT_M
            and self.at_rest
        )

    def __str__(self) -> str:
        text = (
            f"{1000 * self.off_m:.1f} mm and {math.degrees(self.off_rad):.1f}° from the true "
            f"relation; others moved {1000 * self.shift_m:.1f} mm at most"
        )
        return text if self.at_rest else f"{text}; not at rest"


class Judge:
    """Watches a world while its arm carries steps out.

    * `blocks`: of the world, by index: the id without one
    """

    def __init__(self, world: ArmWorld, blocks: Sequence[Block]) -> None:
        self._world, self._blocks = world, blocks

    def begin(self, move: Move) -> Pose:
        """A step begins; gives where its block is to be."""
        self._move, self._before, self._ticks = move, self._poses(), 0
        self._seen: set[Contact] = set()
        self._rightly = self._of_block()
        self._target = target(move, self._blocks, self._before)
        return self._target

    def tick(self) -> None:
        """To be called in each tick of the arm."""
        self._ticks += 1
        self._seen |= self._world.contacts(self._move.moved + 1)

    def end(self, aside: Sequence[Pose] = ()) -> Verdict:
        """The step has ended.

        * `aside`: where other blocks were put that it was said of that they are moved
        """
        moved, after = self._move.moved, self._poses()
        put = {moved, *(self._world.nearest(pose.position)[0] - 1 for pose in aside)}
        shifts = (
            pose.distance_m(self._before[index])
            for index, pose in enumerate(after)
            if index not in put
        )
        rightly = self._rightly | self._of_block()
        carried = {f"block {index + 1}" for index in put}
        touched = sorted(
            f"{one} and {other}"
            for one, other in self._seen - rightly
            if not {one, other} & set(panda.FINGERS) or not {one, other} & carried
        )
        return Verdict(
            after[moved].distance_m(self._target),
            turned_rad(after[moved], self._target),
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

    def _name(self) -> str:
        return f"block {self._move.moved + 1}"

    def _of_block(self) -> set[Contact]:
        """What it stands on now."""
        return {it for it in self._world.contacts(self._move.moved + 1) if self._name() in it}

    def _poses(self) -> list[Pose]:
        return [placed.pose for placed in self._world.placed()]


def turned_rad(one: Pose, other: Pose) -> float:
    """Between the yaws of two blocks, which look the same after a quarter of a turn."""
    yaw = one.yaw_rad() - other.yaw_rad()
    return abs((yaw + math.pi / 4) % (math.pi / 2) - math.pi / 4)
