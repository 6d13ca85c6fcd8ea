"""Moves objects for a controller with the arm, guided by camera images."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.displacements import moved_objects
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult, Mark, retreat, unmarked
from nsrm_harness.manipulation.observing import observe_with_timeout
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import (
    ExecutionOptions,
    ManipulationError,
    SubGoalReached,
    reach_sub_goal,
)
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError
from nsrm_harness.manipulation.stopping import RetreatPath, Stop, StoppedError, never_stopped
from nsrm_harness.nodes.controller import Answer, Tell
from nsrm_harness.nodes.messages import Outcome, SubGoal

TICKS = 20
"""Number of the arm's ticks between two signs of life."""

_LOG = logging.getLogger(__name__)

FAILURES = {
    ExecutionResult.PLACED: Outcome.MISPLACED,
    ExecutionResult.NOT_GRASPED: Outcome.NOT_GRASPED,
    ExecutionResult.SLIPPED: Outcome.DROPPED,
    ExecutionResult.PUT_BACK: Outcome.MISPLACED,
}
"""The controller's outcome for each result of a pick and place after which the block is not seen at
its goal."""
REFUSALS = {
    RefusalReason.UNSEEN: Outcome.IMPOSSIBLE,
    RefusalReason.COVERED: Outcome.COVERED,
    RefusalReason.NO_GRASP: Outcome.CANNOT_HOLD,
    RefusalReason.NO_SUPPORT: Outcome.WOULD_FALL,
    RefusalReason.UNSTABLE: Outcome.WOULD_FALL,
    RefusalReason.NO_ROOM: Outcome.NO_PATH,
    RefusalReason.OUT_OF_REACH: Outcome.OUT_OF_REACH,
    RefusalReason.NO_PATH: Outcome.NO_PATH,
}
"""The outcome for a pick and place that was refused, at first or before a retry."""


def numbered(number: int) -> str:
    """The name of an object that has no other."""
    return f"object {number}"


class ReferenceMovedError(ManipulationError):
    """The reference object is no longer where it was when the command was given."""


def nothing(*_: object) -> None:
    """A callback that does nothing."""


@dataclass(frozen=True)
class SceneMonitor:
    """What a camera shows: all objects that are believed to be there, by number (MoveIt's planning
    scene monitor).

    * `look`: takes an image and observes. Raises `PerceptionError` if nothing can be seen in it
    * `now_s`: the time, seconds, by which the wait for a usable image ends
    * `latest`: the latest observation, without a new image; by default empty
    """

    look: Callable[[], Mapping[int, Cuboid]]
    now_s: Callable[[], float]
    latest: Callable[[], Mapping[int, Cuboid]] = dict


@dataclass(frozen=True)
class Supervisor:
    """Is notified of what the arm does, and may stop it.

    * `alive`: called every few milliseconds during planning and, if `ArmMover.tick` is called,
      during motion
    * `stop`: whether to stop, called as often
    * `mark`: called with each event as it happens
    """

    alive: Callable[[], None] = nothing
    stop: Stop = never_stopped
    mark: Mark = unmarked


class ArmMover:
    """Carries an object from where it is seen to its sub-goal, with one try; blocks that are too
    close are moved aside first.

    * `scene`: what the camera shows. A command fails if the reference object has moved since the
      latest observation before the command, by the time the block is about to be picked up
    * `supervisor`: is notified of what the arm does, and may stop it
    * `planner`: plans the motions; by default one of its own
    * `name`: the name of an object in the log, by its number; unique
    * `log`: receives what it does, and why something was not done
    """

    def __init__(
        self,
        body: RobotInterface,
        scene: SceneMonitor,
        supervisor: Supervisor = Supervisor(),
        *,
        planner: PickAndPlacePlanner | None = None,
        name: Callable[[int], str] = numbered,
        log: logging.Logger = _LOG,
    ) -> None:
        self._body, self._scene, self._supervisor = body, scene, supervisor
        self._planner = planner or PickAndPlacePlanner(alive=self._while_planning)
        self._log, self._spoken, self._numbers = log, name, dict[str, int]()
        self._ticks, self._stop = 0, False
        self._back: RetreatPath | None = None
        self._stuck = ""
        self._carried: frozenset[int] = frozenset()
        self.result: SubGoalReached | HarnessError | None = None
        """The last command's result or error, in more detail than the outcome; None if it was not
        started."""

    @property
    def held(self) -> frozenset[int]:
        """The objects of which the hand may hold one: until it is put down after a stop, and
        permanently if the joints do not follow."""
        return self._carried if self._stuck or self._back else frozenset()

    def __call__(self, command: SubGoal, tell: Tell) -> Answer:
        """Moves the object of a command; `tell` is called with the objects that are moved out of
        its way first."""
        self.tidy_up()
        if self._stuck:
            what = "not begun: %s; check the arm, then restart its controller"
            self._log.error(what, self._stuck)
            return Answer(Outcome.NOT_FOLLOWING)
        self._carried = frozenset([command.object_id])
        self._stop, self.result = False, None
        try:
            reached = self._reach(command, tell)
        except _StoppedPlanningError:
            return Answer(Outcome.STOPPED)
        except StoppedError as stopped:
            self._log.warning("%s", stopped)
            self._back = stopped.back
            return Answer(Outcome.STOPPED)
        except (RefusedError, ManipulationError, StuckError) as error:
            self.result = error
            return self._failed(command, error)
        self.result = reached
        self._log.info("%s", reached)
        return Answer(Outcome.REACHED)

    def _reach(self, command: SubGoal, tell: Tell) -> SubGoalReached:
        """Carries the object of a command to its sub-goal. Raises as `reach_sub_goal`."""
        keep = {command.reference_id, *command.keep} - {0}
        before = dict(self._scene.latest())

        def clearing(names: Sequence[str]) -> None:
            self._log.info("first carried: %s", " and ".join(names))
            numbers = self._numbers_of(names)
            self._carried |= set(numbers)
            tell(Answer(Outcome.CLEARING, numbers))

        def ready(objects: Mapping[str, Cuboid]) -> None:
            now = {self._numbers[name]: cuboid for name, cuboid in objects.items()}
            if command.reference_id in moved_objects(before, now):
                reference = self._name(command.reference_id)
                raise ReferenceMovedError(f"{reference} is no longer where it was; giving up")

        return reach_sub_goal(
            self._body,
            self._planner,
            self._seen,
            self._name(command.object_id),
            goal_of(command),
            ExecutionOptions(
                # Retries are up to the sender of the commands.
                tries=1,
                keep={self._name(number) for number in keep},
                stop=lambda: self._stop,
                mark=self._supervisor.mark,
                tell=clearing,
                ready=ready,
            ),
        )

    def _failed(
        self, command: SubGoal, error: RefusedError | ManipulationError | StuckError
    ) -> Answer:
        """Logs why a command failed; returns its outcome."""
        if isinstance(error, RefusedError):
            self._log.warning("not begun: %s", error)
            return Answer(REFUSALS[error.why], self._numbers_of(error.in_the_way))
        if isinstance(error, StuckError):
            self._log.error("%s", error)
            self._stuck = str(error)
            return Answer(Outcome.NOT_FOLLOWING)
        self._log.warning("%s", error)
        if isinstance(error, ReferenceMovedError):
            return Answer(Outcome.REFERENCE_MOVED, (command.reference_id,))
        if error.done is None:
            # With a single try, the reason is missing only if nothing could be seen.
            return Answer(REFUSALS[error.why or RefusalReason.UNSEEN])
        return Answer(FAILURES[error.done])

    def _seen(self) -> Mapping[str, Cuboid]:
        """All objects that are believed to be there, by name."""
        seen = observe_with_timeout(self._body, self._scene.look, self._scene.now_s)
        return {self._name(number): cuboid for number, cuboid in seen.items()}

    def _name(self, number: int) -> str:
        """The name of an object, which is recorded."""
        name = self._spoken(number)
        self._numbers[name] = number
        return name

    def _numbers_of(self, names: Sequence[str]) -> tuple[int, ...]:
        """The numbers under which these objects were given to the arm, whatever their names."""
        return tuple(self._numbers[name] for name in names)

    def tidy_up(self) -> None:
        """After a stop that has been reported: puts what it holds down where it was picked up, and
        moves out of the camera's view, slowly."""
        back, self._back = self._back, None
        if back is None:
            return
        self._log.warning("the arm goes back, and puts down what it holds where it was")
        try:
            retreat(self._body, back)
        except StuckError as error:
            self._log.error("%s", error)
            self._stuck = str(error)

    def tick(self) -> None:
        """Call this in each tick of the arm, so that it gives signs of life and can be stopped."""
        self._ticks += 1
        if self._ticks % TICKS == 0:
            self._supervisor.alive()
            self._stop = self._stop or self._supervisor.stop()

    def _while_planning(self) -> None:
        self._supervisor.alive()
        if self._supervisor.stop():
            raise _StoppedPlanningError


class _StoppedPlanningError(Exception):
    """The arm was stopped during planning; nothing has moved."""


def goal_of(command: SubGoal) -> Pose:
    """The pose to which a command moves the centre of its object."""
    x, y, z = command.position
    i, j, k, w = command.orientation
    return Pose((x, y, z), (i, j, k, w))
