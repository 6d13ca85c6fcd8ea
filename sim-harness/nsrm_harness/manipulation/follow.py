"""A sentence to its end: planned from a picture, carried out step by step, and planned again
from where the world is no longer as the plan believes. In one process; behind a robot's services
the planner does the same."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import nsrm

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.displacements import DISPLACED_M
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult, Mark, unmarked
from nsrm_harness.manipulation.observing import NoObservationError, observe_with_timeout
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, SubGoalReached, reach_sub_goal
from nsrm_harness.manipulation.robot_interface import RobotInterface
from nsrm_harness.manipulation.stability import resting_on
from nsrm_harness.perception.observer import Observation, Observer, sub_goal
from nsrm_harness.perception.relief import PerceptionError

MAX_ATTEMPTS = 3
"""At one step of a sentence; each has the tries of `reach_sub_goal`."""
COVERED_M = 0.010
"""So far off one may be seen that bears another, which hides a part of it, as long as that one has
stayed where it was."""


class _OvertakenError(ManipulationError):
    """What a block was to go to is no longer where the plan has it."""


def numbered(number: int) -> str:
    """A name for an object that has no other."""
    return f"object {number}"


def nothing(*_: object) -> None:
    """Is told of something and does nothing."""


@dataclass
class _Belief:
    """What is to be done, and where all is believed to stand.

    * `steps`: of the whole sentence, each as it was planned last
    * `poses`: of the objects, by number
    * `done`: the indices of the steps that need nothing more
    """

    steps: list[nsrm.PlannedStep]
    poses: dict[int, Pose]
    done: set[int] = field(default_factory=set)

    def left(self) -> list[int]:
        """The indices of the steps that are to be done, in order."""
        return [index for index in range(len(self.steps)) if index not in self.done]

    def moved(self, sight: Observation) -> set[int]:
        """The objects that are seen elsewhere, or not at all."""
        shifts_m = {
            number: sight.cuboids[number].pose.distance_m(pose)
            if number in sight.cuboids
            else math.inf
            for number, pose in self.poses.items()
        }
        stayed = {
            number: sight.cuboids[number]
            for number, shift_m in shifts_m.items()
            if shift_m <= DISPLACED_M
        }
        return {
            number
            for number in shifts_m.keys() - stayed.keys()
            if shifts_m[number] > COVERED_M or not resting_on(sight.cuboids[number], stayed)
        }

    def undo(self, moved: set[int]) -> None:
        """These objects are no longer as the steps left them that have to do with them."""
        self.done = {index for index in self.done if not moved & self._lasting(index)}

    def _lasting(self, index: int) -> set[int]:
        """The objects that are still as a step left them: neither if a later one has moved its
        block on, and not its reference if one has moved that."""
        step = self.steps[index]
        later = {self.steps[other].object_id for other in self.done if other > index}
        if step.object_id in later:
            return set()
        return {step.object_id, step.reference_id} - later

    def kept(self, step: nsrm.PlannedStep) -> set[int]:
        """What must stay where it is while a step is done."""
        done = [self.steps[index] for index in self.done]
        return {step.reference_id} | {
            number for each in done for number in (each.object_id, each.reference_id)
        }

    def is_outdated(self, moved: set[int]) -> bool:
        """Whether a step that is left goes to one of these, and none before it puts that back."""
        for index in self.left():
            if self.steps[index].reference_id in moved:
                return True
            moved = moved - {self.steps[index].object_id}
        return False


@dataclass
class Follower:
    """Follows sentences with one arm and one camera.

    * `name`: what an object is called, by its number
    * `looked`: is told what is seen, each time
    * `begin`, `end`: are told the index of a step before and after each attempt at it
    * `reached`: is told the index of a step and how its sub-goal was reached
    * `performed`: all of those so far
    """

    body: RobotInterface
    planner: PickAndPlacePlanner
    eyes: Observer
    model: nsrm.Model
    name: Callable[[int], str] = numbered
    mark: Mark = unmarked
    looked: Callable[[Observation], object] = nothing
    begin: Callable[[int], object] = nothing
    end: Callable[[int], None] = nothing
    reached: Callable[[int, SubGoalReached], None] = nothing
    performed: list[SubGoalReached] = field(default_factory=list, init=False)
    _sight: Observation | None = field(default=None, init=False)

    def follow(self, sentence: str) -> None:
        """Has the arm do what a sentence says.

        Raises `nsrm.Refused` if it has no plan, `RefusedError` if a sub-goal can't be reached as
        it looks now, `ManipulationError` if it was tried and is not done: the arm is in its ready
        pose then. Raises `StuckError` where it stands.
        """
        sight = self._look()
        belief = _Belief(self._plan(sight, sentence, 0), _poses(sight))
        attempts: Counter[int] = Counter()
        while left := belief.left():
            index, step = left[0], belief.steps[left[0]]
            if attempts[index] == MAX_ATTEMPTS:
                raise ManipulationError(self._did_not_stay(step), ExecutionResult.PLACED)
            attempts[index] += 1
            self.begin(index)
            try:
                performed = self._perform(step, belief)
            except NoObservationError:
                raise
            except (RefusedError, ManipulationError):
                # What it moves itself was tried often enough.
                has_changed = bool(belief.moved(self._seen()) - {step.object_id})
                if not has_changed or attempts[index] == MAX_ATTEMPTS:
                    raise
            else:
                self.performed.append(performed)
                self.reached(index, performed)
                belief.poses[step.object_id] = self._seen().cuboids[step.object_id].pose
                belief.done.add(index)
            finally:
                self.end(index)
            if moved := belief.moved(self._seen()) - {step.object_id}:
                belief.undo(moved)
                belief.poses = _poses(self._seen())
                if belief.is_outdated(moved):
                    first = belief.left()[0]
                    belief.steps[first:] = self._plan(self._seen(), sentence, first)

    def _plan(self, sight: Observation, sentence: str, first: int) -> list[nsrm.PlannedStep]:
        scene = sight.scene(self.model, self.eyes.camera)
        return list(self.model.plan(scene, sentence, first).steps)

    def _perform(self, step: nsrm.PlannedStep, belief: _Belief) -> SubGoalReached:
        def look() -> Mapping[str, Cuboid]:
            sight = self._look()
            if step.reference_id in belief.moved(sight):
                reference = self.name(step.reference_id)
                raise _OvertakenError(f"{reference} is no longer where it was; I stopped")
            return {self.name(number): cuboid for number, cuboid in sight.cuboids.items()}

        return reach_sub_goal(
            self.body,
            self.planner,
            look,
            self.name(step.object_id),
            sub_goal(step),
            self.mark,
            keep={self.name(number) for number in belief.kept(step)},
        )

    def _did_not_stay(self, step: nsrm.PlannedStep) -> str:
        moved, reference = self.name(step.object_id), self.name(step.reference_id)
        return (
            f"{moved} was to go to {reference}: in {MAX_ATTEMPTS} attempts one of the two did not "
            "stay where it was; I stopped"
        )

    def _seen(self) -> Observation:
        """What was seen last: the arm has not moved since."""
        return self._sight or self._look()

    def _look(self) -> Observation:
        """A picture taken now. Raises `NoObservationError` if there is none for `PATIENCE_S`."""
        begun_s = self.eyes.now_s

        def look() -> Observation:
            sight = self.eyes.look()
            if sight.taken_s < begun_s:
                age_s = self.eyes.now_s - sight.taken_s
                raise PerceptionError(f"the camera's picture is {age_s:.1f} s old")
            return sight

        self._sight = None
        self._sight = sight = observe_with_timeout(self.body, look, lambda: self.eyes.now_s)
        self.looked(sight)
        return sight


def _poses(sight: Observation) -> dict[int, Pose]:
    return {number: cuboid.pose for number, cuboid in sight.cuboids.items()}
