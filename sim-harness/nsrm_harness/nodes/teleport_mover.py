"""Moves objects for a controller without an arm: by physics alone."""

from __future__ import annotations

from collections.abc import Callable

from nsrm_harness.geometry.pose import Vector3
from nsrm_harness.nodes.arm_mover import goal_of
from nsrm_harness.nodes.controller import Answer, Tell
from nsrm_harness.nodes.messages import Outcome, SubGoal
from nsrm_harness.simulation.world import World

GRASP_M = 0.03
"""Maximum distance between where an object is seen and the centre of the block that is picked
up."""
MISPLACED_M = 0.02
"""Maximum distance from its sub-goal at which a block may come to rest."""


class TeleportMover:
    """Moves objects without an arm: lifts a block from where it is seen and releases it above its
    sub-goal.

    * `seen`: where an object is seen, world frame, metres; None if it never was
    """

    def __init__(self, world: World, seen: Callable[[int], Vector3 | None]) -> None:
        self._world, self._seen = world, seen

    def __call__(self, command: SubGoal, tell: Tell) -> Answer:
        """Moves the object of a command; never calls `tell`."""
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
