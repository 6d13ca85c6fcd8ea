"""What moves blocks for a controller without an arm: nothing but physics."""

from __future__ import annotations

from collections.abc import Callable

from nsrm_harness.geometry.pose import Vector3
from nsrm_harness.nodes.arm_mover import goal_of
from nsrm_harness.nodes.controller import Answer, Tell
from nsrm_harness.nodes.messages import Outcome, SubGoal
from nsrm_harness.simulation.world import World

GRASP_M = 0.03
"""How far from where an object is seen a block's centre may be for it to be taken."""
MISPLACED_M = 0.02
"""How far from its sub-goal a block may come to rest."""


class TeleportMover:
    """Without an arm: a block is taken from where it is seen and let go above its sub-goal.

    * `seen`: where an object is seen, world frame, metres; None if it never was
    """

    def __init__(self, world: World, seen: Callable[[int], Vector3 | None]) -> None:
        self._world, self._seen = world, seen

    def __call__(self, command: SubGoal, tell: Tell) -> Answer:
        """Moves an object; what it does besides, `tell` is told."""
        seen, goal = self._seen(command.object_id), goal_of(command)
        if seen is None:
            return Answer(Outcome.IMPOSSIBLE)
        block_id, distance_m = self._world.nearest(seen)
        if distance_m > GRASP_M:
            return Answer(Outcome.NOT_GRASPED)
        self._world.place(block_id, goal)
        if not self._world.settle().at_rest:
            return Answer(Outcome.DROPPED)
        missed = self._world.pose(block_id).distance_m(goal) > MISPLACED_M
        return Answer(Outcome.MISPLACED if missed else Outcome.REACHED)
