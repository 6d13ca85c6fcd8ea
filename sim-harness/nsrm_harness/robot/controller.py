"""The controller of the simulated world: a block is grasped where it is seen, let go
above its sub-goal, and physics does the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.messages import Outcome, SubGoal
from nsrm_harness.world.pose import Pose
from nsrm_harness.world.world import World

GRASP_M = 0.03
"""How far from where an object is seen a block's centre may be for the hand to close on
it: the middle of its visible box lies up to 2 cm from its centre."""
MISPLACED_M = 0.02
"""How far from its sub-goal a block may come to rest."""

MOVE, STOP = 1, 2
"""Kinds of commands: `SubGoal.kind`."""

Say = Callable[[int, int, Outcome], None]
"""Plan, command and how it goes."""
Seen = Callable[[int], NDArray[np.float64] | None]
"""Where an object is seen, world frame, metres."""


@dataclass(frozen=True)
class _Done:
    plan: int
    command: int
    outcome: Outcome


class Controller:
    """Carries out each command once; one that comes again gets the same answer again."""

    def __init__(self, world: World, seen: Seen, say: Say) -> None:
        self._world, self._seen, self._say = world, seen, say
        self._last = _Done(0, 0, Outcome.IMPOSSIBLE)

    def obey(self, command: SubGoal) -> None:
        """Carries out a command, or says why not."""
        plan, number = command.plan, command.command
        if (plan, number) == (self._last.plan, self._last.command):
            # Again: its end is known. A stop that comes after it comes too late.
            self._say(plan, number, self._last.outcome)
            return
        if (plan, number) < (self._last.plan, self._last.command):
            self._say(plan, number, Outcome.IMPOSSIBLE)
            return
        outcome = Outcome.STOPPED if command.kind == STOP else Outcome.IMPOSSIBLE
        if command.kind == MOVE:
            self._say(plan, number, Outcome.ACCEPTED)
            outcome = self._move(command)
        self._last = _Done(plan, number, outcome)
        self._say(plan, number, outcome)

    def _move(self, command: SubGoal) -> Outcome:
        seen = self._seen(command.object_id)
        if seen is None:
            return Outcome.IMPOSSIBLE
        distance, block_id = min(
            (float(np.linalg.norm(np.subtract(pose.position, seen))), block_id)
            for block_id, pose in self._world.poses().items()
        )
        if distance > GRASP_M:
            return Outcome.NOT_GRASPED
        x, y, z = command.position
        i, j, k, w = command.orientation
        goal = Pose((x, y, z), (i, j, k, w))
        self._world.place(block_id, goal)
        if not self._world.settle().at_rest:
            return Outcome.DROPPED
        missed = self._world.pose(block_id).distance_m(goal) > MISPLACED_M
        return Outcome.MISPLACED if missed else Outcome.REACHED
