"""The arm for the open loop: executes commands as if nothing could go wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.execute import Mark, execute
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError
from nsrm_harness.nodes.arm_mover import REFUSALS, goal_of, numbered
from nsrm_harness.nodes.controller import Answer, Tell
from nsrm_harness.nodes.messages import Outcome, SubGoal


class BlindMover:
    """Carries each block once, assumes that it stands where it was last put, and reports success
    without observing.

    * `seen`: the observation before the first command
    """

    result: HarnessError | None = None
    """What prevented it from carrying the last block."""

    def __init__(
        self,
        body: RobotInterface,
        planner: PickAndPlacePlanner,
        seen: Callable[[], Mapping[int, Cuboid]],
        mark: Mark,
    ) -> None:
        self._body, self._planner, self._seen, self._mark = body, planner, seen, mark
        self._believed: dict[str, Cuboid] = {}

    def __call__(self, command: SubGoal, tell: Tell) -> Answer:
        """Carries a block to its sub-goal, as planned."""
        if not self._believed:
            self._believed = {numbered(each): cuboid for each, cuboid in self._seen().items()}
        name, begin = numbered(command.object_id), self._body.joints()
        try:
            carry = self._planner.carry(self._believed, name, goal_of(command), begin)
            execute(self._body, carry, self._mark)
        except RefusedError as refusal:
            self.result = refusal
            return Answer(REFUSALS[refusal.why])
        except StuckError as error:
            self.result = error
            return Answer(Outcome.NOT_FOLLOWING)
        self._believed[name] = carry.placement.cuboid
        return Answer(Outcome.REACHED)
