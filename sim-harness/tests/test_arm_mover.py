"""The arm as a robot's controller: its answers, and what it does when it is stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import closing

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.tabletop import tabletop
from nsrm_harness.evaluation.manipulation_trials.fault_injection import FaultyArm
from nsrm_harness.geometry import panda
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.robot_interface import wait
from nsrm_harness.nodes.arm_mover import ArmMover, SceneMonitor, Supervisor
from nsrm_harness.nodes.controller import Answer, Controller
from nsrm_harness.nodes.messages import Kind, Outcome, SubGoal
from nsrm_harness.perception.observer import Observation, Observer, sub_goal
from nsrm_harness.perception.relief import PerceptionError
from nsrm_harness.simulation.render import Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera

SEED = 4
CROWDED = (221, "put the white block to the left of the magenta block")
"""A block stands where the fingers would have to go, whichever way the white one is held."""
STACKED = 21
"""Its first step puts a block on another."""
NOW_NS = 10**15
STAYED_M = 0.0015
HOME_RAD = 0.01

pytestmark = pytest.mark.slow


def called(number: int) -> str:
    """What a person may call an object: no number can be read from it."""
    return f"the {'big ' * number}one of 9"


class Scene:
    """A scene of the demo, the model's plan for its sentence or another, and the arm."""

    def __init__(self, renderer: Renderer, seed: int, sentence: str | None = None) -> None:
        scene = tabletop(domains.load(), seed)
        self.world = FaultyArm()
        self.world.spawn(scene.arrangement.blocks, scene.arrangement.poses)
        self.world.settle()
        self.observer = Observer(SimulatedCamera(renderer, self.world, default_camera()))
        model = nsrm.Model.pretrained()
        self.sight: Observation = self.observer.look()
        plan = model.plan(self.sight.scene(model, default_camera()), sentence or scene.sentence)
        self.steps = list(plan.steps)
        self.said: list[Outcome] = []
        self.dark_until_s = 0.0
        self.in_the_way: tuple[int, ...] = ()
        self.told: list[tuple[Outcome, int]] = []
        self.waiting: list[SubGoal] = []
        self.while_working: Callable[[], None] = lambda: None
        self.arm = ArmMover(
            self.world,
            SceneMonitor(self.look, lambda: self.world.time_s, lambda: self.sight.cuboids),
            Supervisor(self._work, self._is_stopped),
            name=called,
        )
        self.world.on_tick = self.arm.tick
        self.controller = Controller(self.arm, self._say, self._reject, lambda: NOW_NS)

    def _work(self) -> None:
        self.while_working()

    def _say(self, plan: int, command: int, answer: Answer) -> None:
        self.said.append(answer.outcome)
        self.in_the_way = answer.objects
        self.told += [(answer.outcome, number) for number in answer.objects]

    def _reject(self, service: str, why: str) -> None:
        raise AssertionError(f"{service}: {why}")

    def _is_stopped(self) -> bool:
        return self.controller.is_stopped_by(self.waiting)

    def look(self) -> Mapping[int, Cuboid]:
        if self.world.time_s < self.dark_until_s:
            raise PerceptionError("the camera's picture is dark")
        self.sight = self.observer.look()
        return self.sight.cuboids

    def close(self) -> None:
        self.world.close()

    def command(self, step: int, number: int) -> SubGoal:
        planned = self.steps[step]
        command = SubGoal(plan=1, command=number, kind=Kind.MOVE, step=step, steps=len(self.steps))
        command.object_id, command.reference_id = planned.object_id, planned.reference_id
        command.position[:] = planned.position
        command.orientation[:] = planned.orientation
        done = {n for it in self.steps[:step] for n in (it.object_id, it.reference_id)}
        command.keep[: len(done)] = sorted(done)
        command.until_ns = NOW_NS
        return command

    def obey(self, step: int, number: int, **changed: object) -> list[Outcome]:
        """What is said to a command, then to all that came meanwhile."""
        command = self.command(step, number)
        for name, value in changed.items():
            setattr(command, name, value)
        self.told.clear()
        self.controller.obey(command)
        for command in self.waiting:
            self.controller.obey(command)
        self.waiting.clear()
        said, self.said = self.said, []
        return said

    def off_m(self, step: int) -> float:
        """From where an object is seen to its sub-goal."""
        planned = self.steps[step]
        there = self.look()[planned.object_id].pose
        return there.distance_m(sub_goal(planned))

    def is_home(self) -> bool:
        return float(np.abs(self.world.joints() - panda.READY_RAD).max()) < HOME_RAD


@pytest.fixture
def scene(renderer: Renderer) -> Iterator[Scene]:
    with closing(Scene(renderer, SEED)) as made:
        yield made


STOP_IT = SubGoal(plan=1, command=1, kind=Kind.STOP)


def test_what_is_stopped_is_answered_at_rest_then_tidied_up_and_can_be_told_again(
    scene: Scene,
) -> None:
    before = scene.world.poses()
    heights: list[float] = []
    block_id, _ = scene.world.nearest(scene.sight.cuboids[scene.steps[0].object_id].pose.position)

    def stop_in_the_air() -> None:
        heights.append(scene.world.pose(block_id).position[2])
        if heights[-1] > before[block_id].position[2] + 0.05 and not scene.waiting:
            # One for another command is not for this one.
            scene.waiting.extend([SubGoal(plan=1, command=7, kind=Kind.STOP), STOP_IT])

    scene.while_working = stop_in_the_air
    scene.controller.obey(scene.command(0, 1))
    assert scene.said == [Outcome.ACCEPTED, Outcome.STOPPED]
    assert not scene.is_home()
    assert scene.arm.held == {scene.steps[0].object_id}
    held = scene.world.pose(block_id)
    assert held.position[2] > before[block_id].position[2] + 0.05
    wait(scene.world, 0.5)
    assert scene.world.pose(block_id).distance_m(held) < STAYED_M
    # The stop itself is read, too.
    scene.controller.obey(STOP_IT)
    assert scene.said[2:] == [Outcome.STOPPED]
    scene.while_working = lambda: None
    scene.waiting.clear()
    scene.said.clear()
    scene.arm.tidy_up()
    assert scene.is_home() and scene.arm.held == frozenset()
    for number, pose in scene.world.poses().items():
        assert pose.distance_m(before[number]) < STAYED_M
    assert scene.obey(0, 2) == [Outcome.ACCEPTED, Outcome.REACHED]
    assert scene.off_m(0) < 0.005 and scene.is_home()


def test_who_is_told_anew_after_a_stop_goes_back_first(scene: Scene) -> None:
    beats = 0

    def stop_in_the_middle() -> None:
        nonlocal beats
        beats += 1
        if scene.world.joints()[1] > panda.READY_RAD[1] + 0.3:
            scene.waiting[:] = [STOP_IT]

    scene.while_working = stop_in_the_middle
    assert scene.obey(0, 1) == [Outcome.ACCEPTED, Outcome.STOPPED, Outcome.STOPPED]
    assert not scene.is_home() and beats > 20
    scene.while_working = lambda: None
    assert scene.obey(0, 2) == [Outcome.ACCEPTED, Outcome.REACHED]
    assert scene.off_m(0) < 0.005 and scene.is_home()


def test_what_is_stopped_while_it_is_planned_moves_nothing(scene: Scene) -> None:
    begun_s = scene.world.time_s
    scene.while_working = lambda: scene.waiting.append(STOP_IT)
    scene.controller.obey(scene.command(0, 1))
    assert scene.said == [Outcome.ACCEPTED, Outcome.STOPPED]
    assert scene.world.time_s == begun_s


def test_what_stands_too_near_is_moved_aside(renderer: Renderer) -> None:
    with closing(Scene(renderer, *CROWDED)) as scene:
        before, told = scene.look(), set[int]()
        for step in range(len(scene.steps)):
            said = scene.obey(step, step + 1)
            assert (said[0], said[-1]) == (Outcome.ACCEPTED, Outcome.REACHED)
            told |= {number for outcome, number in scene.told if outcome is Outcome.CLEARING}
            assert (Outcome.CLEARING in said) == bool(scene.told)
            assert scene.off_m(step) < 0.005
        after = scene.look()
        meant = {n for step in scene.steps for n in (step.object_id, step.reference_id)}
        others = [number for number in before if number not in meant]
        moved = {n for n in others if after[n].pose.distance_m(before[n].pose) > 0.01}
        # Each was said before.
        assert moved and moved <= told


def test_an_arm_whose_joints_do_not_follow_begins_nothing_more(
    scene: Scene, caplog: pytest.LogCaptureFixture
) -> None:
    def hold() -> None:
        if scene.world.joints()[1] > panda.READY_RAD[1] + 0.3:
            scene.world.stop()

    scene.while_working = hold
    assert scene.obey(0, 1) == [Outcome.ACCEPTED, Outcome.NOT_FOLLOWING]
    scene.while_working = lambda: None
    joints, time_s = scene.world.joints(), scene.world.time_s
    assert scene.obey(0, 2) == [Outcome.ACCEPTED, Outcome.NOT_FOLLOWING]
    scene.arm.tidy_up()
    assert scene.world.time_s == time_s
    assert scene.arm.held == {scene.steps[0].object_id}
    np.testing.assert_array_equal(scene.world.joints(), joints)
    assert "check the arm, then restart its controller" in caplog.text


def test_an_arm_whose_fingers_do_not_close_begins_nothing_more(
    scene: Scene, caplog: pytest.LogCaptureFixture
) -> None:
    scene.world.is_jammed = True
    assert scene.obey(0, 1) == [Outcome.ACCEPTED, Outcome.NOT_FOLLOWING]
    assert "look at its hand" in caplog.text
    time_s = scene.world.time_s
    assert scene.obey(0, 2) == [Outcome.ACCEPTED, Outcome.NOT_FOLLOWING]
    assert scene.world.time_s == time_s


def test_what_is_not_begun_is_said_with_what_is_in_the_way(scene: Scene) -> None:
    begun_s = scene.world.time_s
    x, y, z = scene.steps[0].position
    for number, (changed, outcome) in enumerate(
        [
            ({"object_id": 77}, Outcome.IMPOSSIBLE),
            ({"position": (x, y, z + 0.2)}, Outcome.WOULD_FALL),
            ({"position": (0.95, 0.6, 0.02)}, Outcome.OUT_OF_REACH),
        ],
        start=1,
    ):
        assert scene.obey(0, number, **changed) == [Outcome.ACCEPTED, outcome]
        assert scene.in_the_way == ()
    assert scene.world.time_s == begun_s


def test_what_stands_on_an_object_is_in_its_way(renderer: Renderer) -> None:
    with closing(Scene(renderer, STACKED)) as scene:
        assert scene.obey(0, 1) == [Outcome.ACCEPTED, Outcome.REACHED]
        first = scene.steps[0]
        swapped = {"object_id": first.reference_id, "reference_id": first.object_id}
        said = scene.obey(0, 2, position=(0.4, -0.2, 0.03), **swapped)
        assert said == [Outcome.ACCEPTED, Outcome.COVERED]
        assert scene.in_the_way == (first.object_id,)


def test_a_camera_that_is_dark_for_a_while_is_waited_for(scene: Scene) -> None:
    scene.dark_until_s = scene.world.time_s + 1.0
    assert scene.obey(0, 1) == [Outcome.ACCEPTED, Outcome.REACHED]
    assert scene.world.time_s > scene.dark_until_s

    def darken() -> None:
        # From now on, and for longer than is waited for.
        scene.dark_until_s = scene.world.time_s + 60.0

    scene.while_working = darken
    begun_s = scene.world.time_s
    assert scene.obey(1, 2) == [Outcome.ACCEPTED, Outcome.IMPOSSIBLE]
    assert begun_s < scene.world.time_s < begun_s + 10.0 and scene.is_home()


def test_a_block_that_is_pushed_away_from_the_hand_is_not_grasped_and_can_be_told_again(
    scene: Scene,
) -> None:
    number = scene.steps[0].object_id
    block_id, _ = scene.world.nearest(scene.sight.cuboids[number].pose.position)
    before = scene.world.pose(block_id)

    def push() -> None:
        if scene.world.joints()[1] > panda.READY_RAD[1] + 0.1:
            x, y, z = before.position
            scene.world.place(block_id, Pose((x - 0.03, y, z), before.orientation))
            scene.while_working = lambda: None

    scene.while_working = push
    said = scene.obey(0, 1)
    assert said[0] == Outcome.ACCEPTED
    assert said[-1] in {Outcome.NOT_GRASPED, Outcome.MISPLACED, Outcome.DROPPED}
    assert scene.is_home()
    assert scene.obey(0, 2) == [Outcome.ACCEPTED, Outcome.REACHED]
    assert scene.off_m(0) < 0.005
