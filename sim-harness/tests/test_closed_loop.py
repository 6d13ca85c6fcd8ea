"""The closed loop executes sentences by what is observed: with a fake arm and camera, and the real
model and executive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from types import SimpleNamespace
from typing import Any, cast

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.demo.carry_out import carry
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult
from nsrm_harness.manipulation.observing import PATIENCE_S, NoObservationError
from nsrm_harness.manipulation.retries import (
    ExecutionOptions,
    Look,
    ManipulationError,
    SubGoalReached,
)
from nsrm_harness.manipulation.robot_interface import StuckError
from nsrm_harness.nodes import arm_mover
from nsrm_harness.nodes.arm_mover import numbered
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.perception.observer import DarkImageError, Observation
from nsrm_harness.visualization.demo_listener import DemoListener, StepResult, Stopped

MODEL = nsrm.Model.pretrained()
CAMERA = default_camera()
COLORS = {1: "red", 2: "blue", 3: "green", 4: "yellow"}
"""Of the blocks, by number."""
ATTEMPTS = nsrm.Limits().attempts
CARRY_S = 5.0
EDGE_M = 0.04
CUBE_M = (EDGE_M, EDGE_M, EDGE_M)
NEAR_M = 0.015
"""A block is where the model has it go, within that."""


def at(x: float, y: float) -> Pose:
    return Pose.upright(x, y, EDGE_M / 2)


def looks() -> dict[int, np.ndarray]:
    """What the model makes of a block of each colour."""
    colors = {
        value.name: value.rgb
        for attribute in domains.load().attributes
        for value in attribute.values
        if value.rgb is not None
    }
    embeddings = {}
    for number, color in COLORS.items():
        crop = np.empty((3, 32, 32), np.float32)
        crop[:] = np.array(colors[color], np.float32)[:, None, None]
        embeddings[number] = MODEL.encode_crop(crop)
    return embeddings


LOOKS = looks()


def location(pose: Pose) -> np.ndarray:
    """Where the camera sees a block."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    pixels = CAMERA.project(corners * EDGE_M / 2 + pose.position)
    size = (CAMERA.width, CAMERA.height)
    (_, _, depth_m) = CAMERA.project(np.add([pose.position], (0.0, 0.0, 0.012)))[0]
    box = (pixels[:, :2].min(axis=0) / size, pixels[:, :2].max(axis=0) / size)
    return np.array([*box[0], *box[1], depth_m], np.float32)


@dataclass(frozen=True, eq=False)
class Picture(Observation):
    """One in which blocks look as they should whatever stands before them."""

    def scene(self, model: nsrm.Model, camera: Any) -> nsrm.Scene:
        """See `Observation`."""
        numbers = list(self.locations)
        rows = np.array([*self.locations.values()], np.float32).reshape(-1, 5)
        embeddings = np.array([LOOKS[number] for number in numbers])
        camera = nsrm.Camera(**asdict(camera))
        boxes, depths = np.ascontiguousarray(rows[:, :4]), np.ascontiguousarray(rows[:, 4])
        return model.scene_from_embeddings(numbers, boxes, depths, embeddings, camera)


class Scene:
    """Four blocks on a table, a camera above it, and an arm that carries one in `CARRY_S`.

    * `steps`: which block goes to the right of which, or to the left
    * `happens`: what a person does in the first, second, … carrying
    * `until_s`: so long the camera shows nothing, or what it showed before
    """

    tick_s = 0.01
    camera = CAMERA

    def __init__(self, *steps: tuple[int, int] | tuple[int, int, str]) -> None:
        self.steps = [(step[0], step[1], step[2] if len(step) == 3 else "right") for step in steps]
        self.sentence = ", then ".join(
            f"put the {COLORS[moved]} block to the {side} of the {COLORS[reference]} block"
            for moved, reference, side in self.steps
        )
        self.poses = {1: at(0.6, -0.1), 2: at(0.6, 0.1), 3: at(0.42, -0.15), 4: at(0.42, 0.1)}
        self.now_s = 1.0
        self.begun_s = self.now_s
        self.happens: dict[int, Callable[[], None]] = {}
        self.attempts: list[int] = []
        self.ended: list[int] = []
        self.carried: list[str] = []
        self.goals: list[Pose] = []
        self.kept: list[set[str]] = []
        self.dark_until_s = self.old_until_s = 0.0
        self._last: Observation | None = None

    # The arm.
    def tick(self) -> None:
        self.now_s += self.tick_s

    def joints(self) -> np.ndarray:
        return np.zeros(7)

    def perform(self, look: Look, name: str, goal: Pose) -> SubGoalReached:
        """As the true one: looks before and after, and puts the block on the table."""
        look()
        number = int(name.split()[-1])
        self.now_s += CARRY_S
        there = at(*goal.position[:2])
        self.poses[number] = there
        self.carried.append(name)
        self.goals.append(there)
        self.happens.pop(len(self.carried), lambda: None)()
        if look()[name].pose == there:
            return SubGoalReached(name, 1, 0.0, 0.0, (), CARRY_S)
        raise ManipulationError(f"{name} was tried", ExecutionResult.PLACED)

    # The camera.
    def look(self) -> Observation:
        if self.now_s < self.dark_until_s:
            raise DarkImageError("the camera's picture is dark")
        if self._last is None or self.now_s >= self.old_until_s:
            cuboids = {number: Cuboid(pose, CUBE_M) for number, pose in self.poses.items()}
            image = np.zeros((1, 1, 3), np.uint8)
            depth, labels = image[..., 0].astype(np.float32), image[..., 0].astype(np.int32)
            seen = {number: location(pose) for number, pose in self.poses.items()}
            self._last = Picture(image, depth, labels, seen, seen, frozenset(), cuboids, self.now_s)
        return self._last

    @property
    def waited_s(self) -> float:
        """Beside the carrying."""
        return self.now_s - self.begun_s - CARRY_S * len(self.carried)

    def loop(self, **told: Any) -> ClosedLoop:
        scene = cast("Any", self)
        return ClosedLoop(scene, cast("Any", SimpleNamespace()), scene, MODEL, **told)

    def follow(self, sentence: str | None = None) -> list[SubGoalReached]:
        loop = self.loop(begin=self.attempts.append, end=self.ended.append)
        loop.follow(self.sentence if sentence is None else sentence)
        return loop.performed

    def move(self, number: int, x: float = 0.5) -> Callable[[], None]:
        """What a person does who puts a block elsewhere."""

        def happens() -> None:
            self.poses[number] = at(x, -0.22 + 0.05 * len(self.carried))

        return happens

    def is_done(self, *steps: int) -> bool:
        """Whether all steps' blocks, or these steps', are where they should be."""
        return all(
            self.poses[moved].distance_m(self.beside(self.poses[reference], side)) < NEAR_M
            for moved, reference, side in (self.steps[it] for it in steps or range(len(self.steps)))
        )

    @staticmethod
    def beside(pose: Pose, side: str = "right") -> Pose:
        """Where the model has a block go that is put beside another."""
        action = {"right": "MoveRight", "left": "MoveLeft"}[side]
        predicted = MODEL.simulate(action, location(at(0.5, 0.0)), location(pose))
        x, y, _ = MODEL.locate(predicted, nsrm.Camera(**asdict(CAMERA)))
        return at(float(x), float(y))


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arm is the scene's."""

    def reach(
        body: Scene, planner: object, look: Look, name: str, goal: Pose, options: ExecutionOptions
    ) -> SubGoalReached:
        assert options.tries == 1
        body.kept.append(set(options.keep))
        options.ready(look())
        return body.perform(look, name, goal)

    monkeypatch.setattr(arm_mover, "reach_sub_goal", reach)


def test_steps_are_done_one_after_the_other() -> None:
    scene = Scene((1, 3), (2, 1))
    performed = scene.follow()
    assert [done.name for done in performed] == scene.carried == ["object 1", "object 2"]
    assert scene.attempts == scene.ended == [0, 1]
    assert scene.is_done()
    # Whatever stands in the way, these are not moved aside.
    assert scene.kept == [{"object 3"}, {"object 1", "object 3"}]


def test_a_step_that_is_undone_is_done_again_and_only_that() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(1)
    scene.follow()
    assert scene.attempts == scene.ended == [0, 1, 0]
    # What it goes to stands where it stood.
    assert scene.is_done()


def test_what_a_later_step_has_moved_on_is_not_fetched_back() -> None:
    scene = Scene((1, 3), (1, 4))
    scene.happens[2] = scene.move(3)
    scene.follow()
    assert scene.attempts == [0, 1] and scene.is_done(1)


@pytest.mark.parametrize(("moved", "again"), [(1, 2), (2, 1)])
def test_what_has_gone_to_one_that_was_moved_on_stays(moved: int, again: int) -> None:
    """The second block is to be where the first one was, not where that is."""
    scene = Scene((1, 3), (2, 1), (1, 4), (3, 4, "left"))
    scene.happens[4] = scene.move(moved)
    scene.follow()
    assert scene.attempts == [0, 1, 2, 3, again]
    # Where it went before, and not beside where the first block is now.
    assert scene.poses[2].distance_m(scene.goals[1]) < 1e-6
    assert scene.is_done(2) and scene.is_done(3) and not scene.is_done(1)


def test_what_the_next_goes_to_is_put_back_before() -> None:
    scene = Scene((1, 3), (2, 1))
    scene.happens[2] = scene.move(1)
    scene.follow()
    assert scene.attempts == [0, 1, 0, 1]
    assert scene.is_done()


def test_when_a_reference_is_moved_what_has_gone_to_it_goes_there_too() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(3)
    scene.follow()
    assert scene.attempts == [0, 1, 0] and scene.is_done()


def test_a_reference_that_is_moved_while_its_block_is_carried() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[2] = scene.move(4)
    scene.follow()
    # The first step has nothing to do with it.
    assert scene.attempts == [0, 1, 1] and scene.is_done()


def test_nothing_more_is_carried_to_where_a_reference_was() -> None:
    scene = Scene((1, 3))
    scene.happens[1] = lambda: (scene.move(1)(), scene.move(3, 0.4)())[0]
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
    assert scene.attempts == [0] and scene.is_done()


def test_what_does_not_stay_is_given_up_in_words() -> None:
    scene = Scene((1, 3), (2, 4))
    for number in range(1, 20):
        scene.happens[number] = scene.move(3)
    with pytest.raises(ManipulationError, match="object 3") as caught:
        scene.follow()
    assert "object 3" in str(caught.value)
    assert scene.attempts == scene.ended == [0] * ATTEMPTS


def test_two_that_undo_each_other_are_given_up_too() -> None:
    scene = Scene((1, 3), (2, 4))
    for number in range(2, 20):
        scene.happens[number] = scene.move(1 + number % 2)
    with pytest.raises(ManipulationError):
        scene.follow()
    assert max(map(scene.attempts.count, (0, 1))) == ATTEMPTS


def test_a_dark_camera_is_waited_for() -> None:
    scene = Scene((1, 3))
    scene.happens[1] = lambda: setattr(scene, "dark_until_s", scene.now_s + 1.0)
    scene.follow()
    assert scene.is_done() and scene.attempts == [0]
    assert 1.0 <= scene.waited_s < 1.5


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
    assert PATIENCE_S <= scene.waited_s < PATIENCE_S + 0.5


def test_what_has_no_plan_is_refused_by_the_model() -> None:
    scene = Scene((1, 3))
    with pytest.raises(nsrm.Refused) as caught:
        scene.follow("put the red block to the right of the cyan block")
    assert caught.value.kind == "no_such_object"
    assert scene.attempts == []
    # Later too.
    scene = Scene((1, 3))
    scene.happens[1] = lambda: scene.poses.pop(3) and None
    with pytest.raises(nsrm.Refused, match="green"):
        scene.follow()
    assert scene.attempts == scene.ended == [0]


class Unable(Scene):
    """Its arm does not do what it is told; what a person does in between may help.

    * `error`: what it raises
    """

    def __init__(self, error: Exception, *steps: tuple[int, int]) -> None:
        super().__init__(*steps)
        self.error = error

    def perform(self, look: Look, name: str, goal: Pose) -> SubGoalReached:
        self.happens.pop(len(self.attempts), lambda: None)()
        self.now_s += CARRY_S
        look()
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
        scene.happens[number] = scene.move(4, 0.45 + 0.01 * number)
    with pytest.raises(type(error)):
        scene.follow()
    assert scene.attempts == scene.ended == [0] * ATTEMPTS


def test_an_arm_that_does_not_follow_is_not_told_anything_more() -> None:
    scene = Unable(StuckError("behind"), (1, 3))
    scene.happens[1] = scene.move(4)
    with pytest.raises(StuckError):
        scene.follow()
    assert scene.attempts == scene.ended == [0]


class Listener(DemoListener):
    """Notes the result of each step."""

    def __init__(self) -> None:
        self.told: list[tuple[int, object]] = []

    def ended(self, index: int, outcome: StepResult) -> None:
        self.told.append((index, outcome))


def demonstrated(scene: Scene) -> tuple[list[SubGoalReached | Stopped], list[tuple[int, object]]]:
    """As the demonstration has it: how each step went in the end, and what was told meanwhile."""
    listener = Listener()
    made_up = cast("Any", scene)
    outcomes = carry(made_up, made_up, MODEL, scene.sentence, numbered, listener)
    return outcomes, listener.told


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


def test_the_demonstration_has_no_outcome_without_a_plan() -> None:
    scene = Scene((1, 3))
    del scene.poses[3]
    with pytest.raises(nsrm.Refused):
        demonstrated(scene)
    # When some of it is done already, this is told.
    scene = Scene((1, 3))
    scene.happens[1] = lambda: scene.poses.pop(3) and None
    *_, outcome = demonstrated(scene)[0]
    assert isinstance(outcome, Stopped) and outcome.moved
    assert outcome.message.startswith("then there was no plan for what is left: step 1: the ref")


def test_a_reference_that_is_moved_before_the_grasp_is_not_gone_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The arm looks before it moves, and what it then sees is planned for."""
    scene = Scene((1, 3))
    look, taken = Scene.look, 0

    def meddled(self: Scene) -> Observation:
        nonlocal taken
        taken += 1
        # Planned in the first picture; the arm begins with the second one.
        if taken == 2:
            self.move(3)()
        return look(self)

    monkeypatch.setattr(Scene, "look", meddled)
    scene.follow()
    assert scene.attempts == scene.ended == [0, 0]
    assert scene.carried == ["object 1"] and scene.is_done()


def test_tries_in_a_row_are_counted_until_the_step_is_reached() -> None:
    scene = Scene((1, 3), (2, 4))
    scene.happens[1] = scene.move(1)
    performed = scene.follow()
    assert scene.attempts == [0, 0, 1]
    assert [(done.name, done.tries) for done in performed] == [("object 1", 2), ("object 2", 1)]


def test_what_fails_after_other_tries_says_so() -> None:
    class Slippery(Unable):
        def perform(self, look: Look, name: str, goal: Pose) -> SubGoalReached:
            if len(self.attempts) == 2:
                self.error = REFUSED
            return super().perform(look, name, goal)

    slipped = ManipulationError("it was tried", ExecutionResult.SLIPPED)
    with pytest.raises(ManipulationError, match="slipped at try 1, and now it would be") as caught:
        Slippery(slipped, (1, 3)).follow()
    assert caught.value.after is ExecutionResult.SLIPPED
    assert caught.value.why is RefusalReason.NO_ROOM
    scene = Unable(slipped, (1, 3))
    with pytest.raises(ManipulationError, match=f"try {ATTEMPTS}: it was tried") as caught:
        scene.follow()
    assert caught.value.done is ExecutionResult.SLIPPED and scene.attempts == [0] * ATTEMPTS
