"""What moves blocks for a controller: the arm, or nothing but physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.arm.carry import Planner
from nsrm_harness.arm.execute import Done, StuckError, carry_out
from nsrm_harness.arm.refused import RefusedError
from nsrm_harness.messages import Outcome
from nsrm_harness.perception.cuboids import Cuboid
from nsrm_harness.world.arm_world import ArmWorld
from nsrm_harness.world.pose import Pose
from nsrm_harness.world.world import World

GRASP_M = 0.03
"""How far from where an object is seen a block's centre may be for it to be taken: the middle of
its visible box lies up to 2 cm from its centre."""
MISPLACED_M = 0.02
"""How far from its sub-goal a block may come to rest."""
TICKS = 20
"""Of the arm, after which it is said that it still works."""

OUTCOMES = {
    Done.PLACED: Outcome.REACHED,
    Done.NOT_GRASPED: Outcome.NOT_GRASPED,
    Done.SLIPPED: Outcome.DROPPED,
    Done.TAKEN_BACK: Outcome.MISPLACED,
}
"""What a controller says of how a carrying ended. Whether a block stands where it was put is seen
by who looks at the next picture."""


class SetsDown:
    """Without an arm: a block is taken from where it is seen and let go above its sub-goal.

    * `seen`: where an object is seen, world frame, metres; None if it never was
    """

    def __init__(self, world: World, seen: Callable[[int], NDArray[np.float64] | None]) -> None:
        self._world, self._seen = world, seen

    def __call__(self, number: int, goal: Pose) -> Outcome:
        """Moves an object."""
        seen = self._seen(number)
        if seen is None:
            return Outcome.IMPOSSIBLE
        block_id, distance_m = self._world.nearest(seen)
        if distance_m > GRASP_M:
            return Outcome.NOT_GRASPED
        self._world.place(block_id, goal)
        if not self._world.settle().at_rest:
            return Outcome.DROPPED
        missed = self._world.pose(block_id).distance_m(goal) > MISPLACED_M
        return Outcome.MISPLACED if missed else Outcome.REACHED


class Carries:
    """The arm carries a block from where it is seen to its sub-goal, once.

    * `seen`: all that is believed to stand there, by number
    * `refuse`: is told why something is not begun, or was stopped
    * `alive`: is called every few milliseconds while it plans and moves
    """

    def __init__(
        self,
        world: ArmWorld,
        seen: Callable[[], Mapping[int, Cuboid]],
        refuse: Callable[[str], None],
        alive: Callable[[], None],
    ) -> None:
        self._seen, self._refuse = seen, refuse
        self._planner = Planner(alive=alive)
        self._world, self._alive, self._ticks = world, alive, 0
        world.on_tick = self._tick

    def __call__(self, number: int, goal: Pose) -> Outcome:
        """Moves an object."""
        objects = {_name(key): cuboid for key, cuboid in self._seen().items()}
        try:
            carry = self._planner.carry(objects, _name(number), goal, self._world.joints())
        except RefusedError as refusal:
            self._refuse(str(refusal))
            return Outcome.NO_PATH
        try:
            return OUTCOMES[carry_out(self._world, carry)]
        except StuckError as error:
            self._refuse(str(error))
            return Outcome.STOPPED

    def _tick(self) -> None:
        self._ticks += 1
        if self._ticks % TICKS == 0:
            self._alive()


def _name(number: int) -> str:
    return f"object {number}"
