"""A sentence is followed to its end by what is seen: by an arm and a camera that are made up."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import nsrm
import numpy as np
import pytest

from nsrm_harness.demo.carry_out import carry
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation import follow
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.follow import MAX_ATTEMPTS, Follower
from nsrm_harness.manipulation.observing import PATIENCE_S, NoObservationError
from nsrm_harness.manipulation.retries import Look, ManipulationError, SubGoalReached
from nsrm_harness.manipulation.robot_interface import StuckError
from nsrm_harness.perception.observer import DarkImageError, Observation
from nsrm_harness.visualization.demo_listener import Stopped

CARRY_S = 5.0
CUBE_M = (0.04, 0.04, 0.04)
Steps = tuple[tuple[int, int], ...]


def at(x: float, y: float) -> Pose:
    return Pose.upright(x, y, 0.02)


def beside(pose: Pose) -> Pose:
    """Where a block goes that is put beside another."""
    x, y, z = pose.position
    return Pose.upright(x, y + 0.07, z)


class Scene:
    """Four blocks on a table, a camera above it, and an arm that carries one in `CARRY_S`.

    * `steps`: which block goes beside which
    * `happens`: what a person does in the first, second, … carrying
    * `until_s`: so long the camera shows nothing, or what it showed before
    """

    tick_s = 0.01
    camera = SimpleNamespace()

    def __init__(self, *steps: tuple[int, int]) -> None:
        self.steps = steps
        self.poses = {number: at(0.4 + 0.05 * number, -0.2) for number in (1, 2, 3, 4)}
        self.now_s = 0.0
        self.happens: dict[int, Callable[[], None]] = {}
        self.attempts: list[int] = []
        self.ended: list[int] = []
        self.carried: list[str] = []
        self.kept: list[set[str]] = []
        self.plans: list[int] = []
        self.dark_until_s = self.old_until_s = 0.0
        self._last: Observation | None = None

    # The arm.
    def tick(self) -> None:
        self.now_s += self.tick_s

    def perform(
        self, body: object, planner: object, look: Look, name: str, goal: Pose, mark: object
    ) -> SubGoalReached:
        """As the true one: looks before and after, and tries again."""
        look()
        number = int(name.split()[-1])
        for number_of_try in (1, 2, 3):
            self.now_s += CARRY_S
            self.poses[number] = goal
            self.carried.append(name)
            self.happens.pop(len(self.carried), lambda: None)()
            if look()[name].pose == goal:
                return SubGoalReached(name, number_of_try, 0.0, 0.0, (), CARRY_S)
        raise ManipulationError(f"{name} was tried")

    # The camera.
    def look(self) -> Observation:
        if self.now_s < self.dark_until_s:
            raise DarkImageError("the camera's picture is dark")
        if self._last is None or self.now_s >= self.old_until_s:
            cuboids = {number: Cuboid(pose, CUBE_M) for number, pose in self.poses.items()}
            image = np.zeros((1, 1, 3), np.uint8)
            depth, labels = image[..., 0].astype(np.float32), image[..., 0].astype(np.int32)
            self._last = Observation(image, depth, labels, {}, {}, frozenset(), cuboids, self.now_s)
        return self._last

    # The model.
    def plan(self, sight: Observation, sentence: str, first: int = 0) -> SimpleNamespace:
        self.plans.append(first)
        poses = {number: cuboid.pose for number, cuboid in sight.cuboids.items()}
        planned = []
        for index, (moved, reference) in enumerate(self.steps):
            if index >= first:
                poses[moved] = beside(poses[reference])
                planned.append(
                    SimpleNamespace(
                        object_id=moved,
                        reference_id=reference,
                        position=poses[moved].position,
                        orientation=poses[moved].orientation,
                    )
                )
        return SimpleNamespace(steps=planned)

    def follow(self) -> list[SubGoalReached]:
        scene = cast("Any", self)
        follower = Follower(
            scene, scene, scene, scene, begin=self.attempts.append, end=self.ended.append
        )
        follower.follow("so")
        return follower.performed

    def move(self, number: int, y: float = 0.2) -> Callable[[], None]:
        """What a person does who puts a block elsewhere."""

        def happens() -> None:
            self.poses[number] = at(0.3 + 0.05 * len(self.carried), y)

        return happens

    def is_done(self) -> bool:
        return all(
            self.poses[moved].distance_m(beside(self.poses[reference])) < 1e-6
            for moved, reference in self.steps
        )


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arm and the model's view are the scene's."""

    def perform(body: Scene, *arguments: Any, keep: set[str]) -> SubGoalReached:
        body.kept.append(keep)
        return body.perform(body, *arguments)

    monkeypatch.setattr(follow, "perform", perform)
    monkeypatch.setattr(Observation, "scene", lambda self, model, camera: self)


def test_steps_are_done_one_after_the_other_by_one_plan() -> None:
    scene = Scene((1, 3), (2, 1))
    performed = scene.follow()
    assert [done.name for done in performed] == scene.carried == ["object 1", "object 2"]
    assert scene.attempts == scene.ended == [0, 1]
    assert scene.plans == [0] and scene.is_done()
    # Whatever stands in the way, these are not moved aside.
    assert scene.kept == [{"object 3"}, {"object 1", "object 3"}]


def test_a_step_that_is_undone_is_done_again_and_only_that() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(1)
    scene.follow()
    assert scene.attempts == scene.ended == [0, 1, 0]
    # What it goes to stands where it stood.
    assert scene.plans == [0] and scene.is_done()


def test_what_a_later_step_has_moved_on_is_not_fetched_back() -> None:
    scene = Scene((1, 3), (1, 4))
    scene.happens[2] = scene.move(3)
    scene.follow()
    assert scene.attempts == [0, 1] and scene.poses[1] == beside(scene.poses[4])


@pytest.mark.parametrize(("moved", "again"), [(1, 2), (2, 1)])
def test_what_has_gone_to_one_that_was_moved_on_stays(moved: int, again: int) -> None:
    """The second block is to be where the first one was, not where that is."""
    scene = Scene((1, 3), (2, 1), (1, 4), (3, 4))
    there = beside(beside(scene.poses[3]))
    scene.happens[4] = scene.move(moved)
    scene.follow()
    assert scene.attempts == [0, 1, 2, 3, again] and scene.plans == [0]
    assert scene.poses[2] == there and scene.poses[1] == beside(scene.poses[4])


def test_what_the_next_goes_to_is_put_back_before_by_the_plan_there_is() -> None:
    scene = Scene((1, 3), (2, 1))
    scene.happens[2] = scene.move(1)
    scene.follow()
    assert scene.attempts == [0, 1, 0, 1]
    assert scene.plans == [0] and scene.is_done()


def test_when_a_reference_is_moved_what_has_gone_to_it_goes_there_too() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(3)
    scene.follow()
    assert scene.attempts == [0, 1, 0] and scene.plans == [0, 0] and scene.is_done()


def test_a_reference_that_is_moved_while_its_block_is_carried() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(4)
    scene.follow()
    # The first step has nothing to do with it.
    assert scene.attempts == [0, 1, 1] and scene.plans == [0, 1] and scene.is_done()


def test_nothing_more_is_carried_to_where_a_reference_was() -> None:
    scene = Scene((1, 3))
    scene.happens[1] = lambda: (scene.move(1)(), scene.move(3, 0.0)())[0]
    scene.follow()
    assert scene.carried == ["object 1", "object 1"]
    assert scene.attempts == [0, 0] and scene.is_done()


@pytest.mark.parametrize(
    ("shift_m", "with_what_it_bears", "is_moved"),
    [(0.004, False, False), (0.012, False, True), (0.004, True, True)],
)
def test_one_that_bears_another_is_seen_less_well(
    shift_m: float, with_what_it_bears: bool, is_moved: bool
) -> None:
    def shift() -> None:
        for number in (3, 4) if with_what_it_bears else (3,):
            x, y, z = scene.poses[number].position
            scene.poses[number] = Pose.upright(x + shift_m, y, z)

    scene = Scene((1, 3))
    x, y, _ = scene.poses[3].position
    scene.poses[4] = Pose.upright(x, y, 0.06)
    scene.happens[1] = shift
    scene.follow()
    assert scene.attempts == ([0, 0] if is_moved else [0])


def test_a_block_that_nobody_spoke_of_may_be_moved() -> None:
    scene = Scene((1, 3))
    scene.happens[1] = scene.move(4)
    scene.follow()
    assert scene.attempts == [0] and scene.plans == [0]


def test_what_does_not_stay_is_given_up_in_words() -> None:
    scene = Scene((1, 3), (2, 4))
    for number in range(1, 20):
        scene.happens[number] = scene.move(3)
    with pytest.raises(ManipulationError, match="object 3") as caught:
        scene.follow()
    assert "object 3" in str(caught.value)
    assert scene.attempts == scene.ended == [0] * MAX_ATTEMPTS


def test_two_that_undo_each_other_are_given_up_too() -> None:
    scene = Scene((1, 3), (2, 4))
    for number in range(2, 20):
        scene.happens[number] = scene.move(1 + number % 2)
    with pytest.raises(ManipulationError):
        scene.follow()
    assert max(map(scene.attempts.count, (0, 1))) == MAX_ATTEMPTS


def test_a_dark_camera_is_waited_for() -> None:
    scene = Scene((1, 3))
    scene.happens[1] = lambda: setattr(scene, "dark_until_s", scene.now_s + 1.0)
    scene.follow()
    assert scene.is_done() and scene.attempts == [0]
    assert 1.0 <= scene.now_s - CARRY_S < 1.5


def test_a_picture_that_is_old_is_not_believed() -> None:
    scene = Scene((1, 3))

    def happens() -> None:
        scene.old_until_s = scene.now_s + 1.0
        scene.move(3)()

    scene.happens[1] = happens
    scene.follow()
    assert scene.is_done() and scene.attempts == [0, 0]


@pytest.mark.parametrize(("what", "words"), [("dark_until_s", "dark"), ("old_until_s", "old")])
def test_one_that_shows_nothing_new_any_more_ends_in_words(what: str, words: str) -> None:
    scene = Scene((1, 3), (2, 4))

    def happens() -> None:
        setattr(scene, what, 1e9)
        # It would be a reason to try again, if it were seen.
        scene.move(3)()

    scene.happens[1] = happens
    with pytest.raises(NoObservationError, match=words):
        scene.follow()
    assert scene.carried == ["object 1"] and scene.attempts == scene.ended == [0]
    assert PATIENCE_S <= scene.now_s - CARRY_S < PATIENCE_S + 0.5


def test_what_has_no_plan_is_refused_by_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise nsrm.Refused("no such object")

    scene = Scene((1, 3))
    monkeypatch.setattr(scene, "plan", refuse)
    with pytest.raises(nsrm.Refused, match="no such object"):
        scene.follow()
    assert scene.attempts == []
    # Later too.
    scene = Scene((1, 3))
    scene.happens[1] = lambda: (scene.move(3)(), monkeypatch.setattr(scene, "plan", refuse))[0]
    with pytest.raises(nsrm.Refused):
        scene.follow()
    assert scene.attempts == scene.ended == [0]


class Unable(Scene):
    """Its arm does not do what it is told; what a person does in between may help.

    * `error`: what it raises
    """

    def __init__(self, error: Exception, *steps: tuple[int, int]) -> None:
        super().__init__(*steps)
        self.error = error

    def perform(self, *arguments: Any) -> SubGoalReached:
        self.happens.pop(len(self.attempts), lambda: None)()
        self.now_s += CARRY_S
        arguments[2]()
        raise self.error


REFUSED = RefusedError(RefusalReason.NO_ROOM, "it would be 1 mm from object 4")


@pytest.mark.parametrize("error", [REFUSED, ManipulationError("it was tried")])
def test_what_can_not_be_done_is_tried_again_only_if_something_else_has_changed(
    error: Exception,
) -> None:
    scene = Unable(error, (1, 3))
    with pytest.raises(type(error)):
        scene.follow()
    assert scene.attempts == [0]
    scene = Unable(error, (1, 3))
    scene.happens[1] = scene.move(4)
    with pytest.raises(type(error)):
        scene.follow()
    assert scene.attempts == [0, 0]
    scene = Unable(error, (1, 3))
    for number in range(1, 20):
        scene.happens[number] = scene.move(4, 0.05 * number)
    with pytest.raises(type(error)):
        scene.follow()
    assert scene.attempts == scene.ended == [0] * MAX_ATTEMPTS


def test_an_arm_that_does_not_follow_is_not_told_anything_more() -> None:
    scene = Unable(StuckError("behind"), (1, 3))
    scene.happens[1] = scene.move(4)
    with pytest.raises(StuckError):
        scene.follow()
    assert scene.attempts == scene.ended == [0]


def demonstrated(scene: Scene) -> tuple[list[SubGoalReached | Stopped], list[tuple[int, object]]]:
    """As the demonstration has it: how each step went in the end, and what was told meanwhile."""
    told: list[tuple[int, object]] = []
    made_up = cast("Any", scene)
    outcomes = carry(
        made_up,
        made_up,
        made_up,
        "so",
        follow.numbered,
        follow.nothing,
        follow.nothing,
        lambda *what: told.append(what),
    )
    return outcomes, told


def test_the_demonstration_tells_how_each_step_went_in_the_end() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(1)
    outcomes, told = demonstrated(scene)
    assert scene.carried == ["object 1", "object 2", "object 1"] and scene.is_done()
    assert [index for index, _ in told] == [0, 1, 0]
    assert outcomes == [told[2][1], told[1][1]]


@pytest.mark.parametrize(
    ("error", "moved"),
    [(REFUSED, False), (ManipulationError("it fell"), True), (StuckError("it"), True)],
)
def test_the_demonstration_tells_why_it_stopped(error: Exception, moved: bool) -> None:
    outcomes, told = demonstrated(Unable(error, (1, 3), (2, 4)))
    assert outcomes == [Stopped(moved, str(error))] and told == [(0, outcomes[0])]


def test_the_demonstration_has_no_outcome_without_a_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise nsrm.Refused("no such object")

    scene = Scene((1, 3))
    monkeypatch.setattr(scene, "plan", refuse)
    with pytest.raises(nsrm.Refused):
        demonstrated(scene)
    # When some of it is done already, this is told.
    scene = Scene((1, 3))
    scene.happens[1] = lambda: (scene.move(3)(), monkeypatch.setattr(scene, "plan", refuse))[0]
    (outcome,), _ = demonstrated(scene)
    assert isinstance(outcome, Stopped) and outcome.moved
    assert outcome.message == "then there was no plan for what is left: no such object"
