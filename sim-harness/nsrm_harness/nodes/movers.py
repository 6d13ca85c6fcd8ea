"""What moves blocks for a controller: the arm, or nothing but physics."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult, retreat
from nsrm_harness.manipulation.observing import observe_with_timeout
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, reach_sub_goal
from nsrm_harness.manipulation.robot_interface import StuckError
from nsrm_harness.manipulation.stopping import RetreatPath, StoppedError
from nsrm_harness.nodes.controller import Answer, Tell
from nsrm_harness.nodes.messages import Outcome, SubGoal
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.world import World

GRASP_M = 0.03
"""How far from where an object is seen a block's centre may be for it to be taken."""
MISPLACED_M = 0.02
"""How far from its sub-goal a block may come to rest."""
TICKS = 20
"""Of the arm, after which it is said that it still works."""

_LOG = logging.getLogger(__name__)

FAILURES = {
    ExecutionResult.PLACED: Outcome.MISPLACED,
    ExecutionResult.NOT_GRASPED: Outcome.NOT_GRASPED,
    ExecutionResult.SLIPPED: Outcome.DROPPED,
    ExecutionResult.TAKEN_BACK: Outcome.MISPLACED,
}
"""What a controller says of a carrying that ended so, and the block is not seen where it was to
go."""
REFUSALS = {
    RefusalReason.UNSEEN: Outcome.IMPOSSIBLE,
    RefusalReason.COVERED: Outcome.COVERED,
    RefusalReason.NO_GRASP: Outcome.CANNOT_HOLD,
    RefusalReason.NO_SUPPORT: Outcome.WOULD_FALL,
    RefusalReason.UNSTABLE: Outcome.WOULD_FALL,
    RefusalReason.NO_ROOM: Outcome.NO_PATH,
    RefusalReason.OUT_OF_REACH: Outcome.OUT_OF_REACH,
    RefusalReason.NO_WAY: Outcome.NO_PATH,
}
"""And of one that was not begun, or not begun again."""


def numbered(number: int) -> str:
    """What an object is called that has no other name."""
    return f"object {number}"


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


class ArmMover:
    """The arm carries a block from where it is seen to its sub-goal, once; what only stands too
    near is moved aside first.

    * `look`: takes a picture; gives all that is believed to stand there, by number. Raises
      `PerceptionError` where nothing can be seen on it, and is waited for then
    * `alive`: is called every few milliseconds while it plans and moves
    * `stop`: whether it is to stop, asked as often
    * `name`: what an object is called in the log, by its number; no two the same
    """

    def __init__(
        self,
        world: ArmWorld,
        look: Callable[[], Mapping[int, Cuboid]],
        alive: Callable[[], None],
        stop: Callable[[], bool],
        name: Callable[[int], str] = numbered,
    ) -> None:
        self._look, self._alive, self._asked_to_stop = look, alive, stop
        self._spoken, self._numbers = name, dict[str, int]()
        self._planner = PickAndPlacePlanner(alive=self._while_planning)
        self._world, self._ticks, self._stop = world, 0, False
        self._back: RetreatPath | None = None
        self._stuck = ""
        self._plan, self._meant = 0, set[int]()
        self._carried: frozenset[int] = frozenset()
        world.on_tick = self._tick

    @property
    def held(self) -> frozenset[int]:
        """The objects of which the hand may hold one: until what was stopped is put down, and
        for ever where the joints don't follow."""
        return self._carried if self._stuck or self._back else frozenset()

    def __call__(self, command: SubGoal, tell: Tell) -> Answer:
        """Moves an object; what is moved out of its way first, `tell` is told."""
        self.tidy_up()
        if self._stuck:
            _LOG.error("not begun: %s; look at the arm and start its controller anew", self._stuck)
            return Answer(Outcome.NOT_FOLLOWING)
        if command.plan != self._plan:
            self._plan, self._meant = command.plan, set()
        # What this plan has moved, or put something beside, stays where it is.
        self._meant |= {command.object_id, command.reference_id}
        self._carried = frozenset([command.object_id])
        self._stop = False

        def clearing(names: Sequence[str]) -> None:
            _LOG.info("first carried: %s", " and ".join(names))
            numbers = self._numbers_of(names)
            self._carried |= set(numbers)
            tell(Answer(Outcome.CLEARING, numbers))

        try:
            performed = reach_sub_goal(
                self._world,
                self._planner,
                self._seen,
                self._name(command.object_id),
                goal_of(command),
                keep={self._name(number) for number in self._meant},
                # Whether and how it is tried again is for who sends the commands.
                tries=1,
                stop=lambda: self._stop,
                tell=clearing,
            )
        except RefusedError as refusal:
            _LOG.warning("not begun: %s", refusal)
            return Answer(REFUSALS[refusal.why], self._numbers_of(refusal.in_the_way))
        except ManipulationError as failure:
            _LOG.warning("%s", failure)
            if failure.done is None:
                # One that is not tried again has no other end without a reason.
                return Answer(REFUSALS[failure.why or RefusalReason.UNSEEN])
            return Answer(FAILURES[failure.done])
        except _StoppedPlanningError:
            return Answer(Outcome.STOPPED)
        except StoppedError as stopped:
            _LOG.warning("%s", stopped)
            self._back = stopped.back
            return Answer(Outcome.STOPPED)
        except StuckError as error:
            _LOG.error("%s", error)
            self._stuck = str(error)
            return Answer(Outcome.NOT_FOLLOWING)
        _LOG.info("%s", performed)
        return Answer(Outcome.REACHED)

    def _seen(self) -> Mapping[str, Cuboid]:
        """All that is believed to stand there, by name."""
        seen = observe_with_timeout(self._world, self._look, lambda: self._world.time_s)
        return {self._name(number): cuboid for number, cuboid in seen.items()}

    def _name(self, number: int) -> str:
        """What the arm calls an object."""
        name = self._spoken(number)
        self._numbers[name] = number
        return name

    def _numbers_of(self, names: Sequence[str]) -> tuple[int, ...]:
        """Of objects that the arm speaks of: as they were given to it, whatever they are called."""
        return tuple(self._numbers[name] for name in names)

    def tidy_up(self) -> None:
        """After a stop that has been answered: puts what it holds down where it was taken, and
        goes out of the camera's view, slowly."""
        back, self._back = self._back, None
        if back is None:
            return
        _LOG.warning("the arm goes back, and puts down what it holds where it was")
        try:
            retreat(self._world, back)
        except StuckError as error:
            _LOG.error("%s", error)
            self._stuck = str(error)

    def _tick(self) -> None:
        self._ticks += 1
        if self._ticks % TICKS == 0:
            self._alive()
            self._stop = self._stop or self._asked_to_stop()

    def _while_planning(self) -> None:
        self._alive()
        if self._asked_to_stop():
            raise _StoppedPlanningError


class _StoppedPlanningError(Exception):
    """Nothing has moved."""


def goal_of(command: SubGoal) -> Pose:
    """Where a command wants the centre of its object."""
    x, y, z = command.position
    i, j, k, w = command.orientation
    return Pose((x, y, z), (i, j, k, w))
