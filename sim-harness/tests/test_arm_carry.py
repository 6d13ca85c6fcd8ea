"""Blocks are carried by friction alone, and whatever goes wrong ends at rest and in words."""

from __future__ import annotations

import itertools
import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_scenes import above
from world_scenes import DOMAIN

from nsrm_harness.arm import panda
from nsrm_harness.arm.carry import Carry, Planner
from nsrm_harness.arm.execute import Done, carry_out
from nsrm_harness.arm.kinematics import Joints
from nsrm_harness.arm.perform import MAX_TRIES, FailedError, Look, perform
from nsrm_harness.arm.refused import RefusedError, Why
from nsrm_harness.perception.cuboids import Cuboid
from nsrm_harness.sight import Eyes
from nsrm_harness.world.arm_world import ArmWorld
from nsrm_harness.world.blocks import block_from_attributes
from nsrm_harness.world.bullet import pybullet
from nsrm_harness.world.camera import default_camera
from nsrm_harness.world.pose import Pose
from nsrm_harness.world.render import Renderer

TESTS = Path(__file__).parent

PLACED_M = 0.001
PLACED_RAD = math.radians(3)
STAYED_M = 0.0005
HOME_RAD = 0.02


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


def put(world: ArmWorld, *blocks: tuple[str, float, float, float, float]) -> None:
    """Each of a size at x, y and a height of its foot, turned by a yaw; named by its number."""
    colors = itertools.cycle(("red", "green", "blue", "yellow", "magenta", "cyan"))
    made = [
        block_from_attributes(DOMAIN, {"color": color, "size": size})
        for color, (size, *_) in zip(colors, blocks, strict=False)
    ]
    poses = [
        Pose.upright(x, y, foot + block.edges_m[2] / 2, yaw)
        for block, (_, x, y, foot, yaw) in zip(made, blocks, strict=True)
    ]
    world.spawn(made, poses)
    assert world.settle().at_rest


def three(world: ArmWorld) -> None:
    """A small block, a large one and another small one."""
    put(world, ("small", 0.45, -0.1, 0, 0.3), ("lego", 0.5, 0.1, 0, -0.2), ("small", 0.6, 0, 0, 0))


BESIDE = Pose.upright(0.5, -0.2, 0.02)
ON_THE_LARGE_ONE = Pose.upright(0.5, 0.1, 0.07)


def known(world: ArmWorld) -> Look:
    """All blocks where they are."""
    return lambda: {
        str(placed.id): Cuboid(placed.pose, placed.block.edges_m) for placed in world.placed()
    }


def pictured(world: ArmWorld, renderer: Renderer) -> Look:
    """All blocks where pictures show them."""
    eyes = Eyes(renderer, world, default_camera())
    names = {
        number: str(world.nearest(cuboid.pose.position)[0])
        for number, cuboid in eyes.look().cuboids.items()
    }

    def look() -> Mapping[str, Cuboid]:
        cuboids = eyes.look().cuboids
        return {names.get(number, f"new {number}"): cuboids[number] for number in cuboids}

    return look


class Noting(Planner):
    """Keeps what it planned."""

    def __init__(self) -> None:
        super().__init__()
        self.carries: list[Carry] = []

    def carry(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints, **how: bool
    ) -> Carry:
        self.carries.append(super().carry(objects, name, goal, begin, **how))
        return self.carries[-1]


class Through:
    """Passes everything on to an arm in its world; what meddles with it is derived from it."""

    def __init__(self, world: ArmWorld) -> None:
        self.world = world

    @property
    def tick_s(self) -> float:
        return self.world.tick_s

    def drive(self, joints: Joints, speeds: Joints) -> None:
        self.world.drive(joints, speeds)

    def grip(self, opening_m: float, force_n: float) -> None:
        self.world.grip(opening_m, force_n)

    def joints(self) -> Joints:
        return self.world.joints()

    def opening_m(self) -> float:
        return self.world.opening_m()

    def tick(self) -> None:
        self.world.tick()


class Watched(Through):
    """Keeps how the joints were driven, how they turned, and every so often who was touched."""

    LOOK_TICKS = 20

    def __init__(self, world: ArmWorld) -> None:
        super().__init__(world)
        self.driven: list[tuple[Joints, Joints]] = []
        self.turned = [world.joints()]
        self.touched: list[set[tuple[str, str]]] = []
        self._names = {body: str(block_id) for block_id, body in world._bodies.items()}
        self._links = {index: name for name, index in world._arm._links.items()}

    def drive(self, joints: Joints, speeds: Joints) -> None:
        self.driven.append((joints, speeds))
        super().drive(joints, speeds)

    def tick(self) -> None:
        super().tick()
        self.turned.append(self.world.joints())
        if len(self.turned) % self.LOOK_TICKS == 0:
            self.touched.append(self._touched())

    def _touched(self) -> set[tuple[str, str]]:
        """Pairs of a link and what it touches."""
        arm = self.world._arm._body
        points = pybullet.getContactPoints(bodyA=arm, physicsClientId=self.world._client)
        return {
            (self._links.get(point[3], "base"), self._names.get(point[2], "table or arm"))
            for point in points
            if point[8] <= 0.0
        }


class Still(Through):
    """May be asked where it is, and not be moved."""

    def drive(self, joints: Joints, speeds: Joints) -> None:
        pytest.fail("it was driven")

    def grip(self, opening_m: float, force_n: float) -> None:
        pytest.fail("its fingers were moved")

    def tick(self) -> None:
        pytest.fail("time went on")


def at_home(world: ArmWorld) -> bool:
    return float(np.abs(world.joints() - panda.READY_RAD).max()) < HOME_RAD


def turn_rad(one: Pose, other: Pose, same_rad: float) -> float:
    """From one to the other, up to turns after which it looks the same."""
    turn = other.yaw_rad() - one.yaw_rad()
    return turn - same_rad * round(turn / same_rad)


@pytest.mark.parametrize("goal", [BESIDE, ON_THE_LARGE_ONE])
@pytest.mark.parametrize("by_pictures", [False, True])
def test_a_block_is_carried_to_its_sub_goal_and_nothing_else_moves(
    world: ArmWorld, renderer: Renderer, goal: Pose, by_pictures: bool
) -> None:
    three(world)
    before = world.poses()
    body, planner = Watched(world), Noting()
    look = pictured(world, renderer) if by_pictures else known(world)
    performed = perform(body, planner, look, "1", goal)
    assert performed.name == "1" and performed.tries == 1 and performed.shifted == ()
    (carry,) = planner.carries
    target, after = carry.placement.cuboid.pose, world.poses()
    # What is held is held as it was seen: its error goes with it.
    seen_m = 0.001 if by_pictures else 0.0
    assert after[1].distance_m(target) < PLACED_M + seen_m
    assert after[1].angle_rad(target) < PLACED_RAD
    # It is square: a quarter turn can't be seen.
    assert abs(turn_rad(goal, after[1], math.pi / 2)) < PLACED_RAD
    assert target.distance_m(goal) == pytest.approx(performed.corrected_m)
    assert performed.corrected_m < 0.0015 and performed.miss_m < PLACED_M + seen_m
    for other in (2, 3):
        assert after[other].distance_m(before[other]) < STAYED_M
    assert at_home(world) and world.settle().at_rest
    assert world.pose(1).distance_m(after[1]) < STAYED_M


@pytest.mark.parametrize(
    ("edges_m", "same_rad"), [((0.04, 0.04, 0.04), math.pi / 2), ((0.06, 0.03, 0.04), math.pi)]
)
def test_it_is_turned_as_little_as_the_sub_goal_allows(
    edges_m: tuple[float, float, float], same_rad: float
) -> None:
    for begin_rad, goal_rad in ((0.3, 1.2), (0.1, -2.9)):
        block = Cuboid(Pose.upright(0.45, -0.1, 0.02, begin_rad), edges_m)
        goal = Pose.upright(0.55, 0.1, 0.02, goal_rad)
        carry = Planner().carry({"block": block}, "block", goal, panda.READY_RAD)
        target = carry.placement.cuboid
        assert target.edges_m == edges_m
        assert target.pose.distance_m(goal) < 1e-9
        assert abs(turn_rad(goal, target.pose, same_rad)) < 1e-9
        turned = turn_rad(block.pose, target.pose, 2 * math.pi)
        assert abs(turned) <= same_rad / 2 + 1e-9


def test_the_arm_is_driven_and_turns_within_the_makers_limits(world: ArmWorld) -> None:
    three(world)
    body = Watched(world)
    perform(body, Planner(), known(world), "1", ON_THE_LARGE_ONE)
    joints, speeds = (np.array(part) for part in zip(*body.driven, strict=True))
    assert (joints >= panda.LOWEST_RAD).all() and (joints <= panda.HIGHEST_RAD).all()
    assert (np.abs(speeds) <= panda.MAX_SPEED_RAD_S).all()
    # What it is told leads on from what it was told before.
    turned = np.array(body.turned)
    for driven in (joints, turned):
        rates = np.diff(driven, axis=0) / world.tick_s
        assert (np.abs(rates) <= panda.MAX_SPEED_RAD_S).all()
    assert np.abs(speeds).max() > 0.5


def test_the_block_is_held_by_friction_alone(
    world: ArmWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    three(world)
    # One constraint: the gear between the two fingers.
    client, arm = world._client, world._arm._body
    assert pybullet.getNumConstraints(physicsClientId=client) == 1
    info: Any = pybullet.getConstraintInfo(1, physicsClientId=client)
    assert (info[0], info[2], info[4]) == (arm, arm, pybullet.JOINT_GEAR)

    may_be_called = {
        "stepSimulation",
        "setPhysicsEngineParameter",
        "setJointMotorControlArray",
        "setJointMotorControl2",
    }

    def forbid(name: str) -> Callable[..., None]:
        def forbidden(*_: object, **__: object) -> None:
            pytest.fail(f"{name} was called")

        return forbidden

    for name in dir(pybullet):
        is_asking = name.startswith("get")
        if callable(getattr(pybullet, name)) and not is_asking and name not in may_be_called:
            monkeypatch.setattr(pybullet, name, forbid(name))
    with pytest.raises(pytest.fail.Exception, match="createConstraint"):
        pybullet.createConstraint()
    perform(world, Planner(), known(world), "1", ON_THE_LARGE_ONE)
    # To be able to close.
    monkeypatch.undo()
    assert world.pose(1).distance_m(ON_THE_LARGE_ONE) < PLACED_M


def test_without_friction_nothing_is_carried(world: ArmWorld) -> None:
    three(world)
    before = world.poses()
    for finger in world._arm._fingers:
        pybullet.changeDynamics(
            world._arm._body,
            finger,
            lateralFriction=0.0,
            spinningFriction=0.0,
            rollingFriction=0.0,
            physicsClientId=world._client,
        )
    with pytest.raises(FailedError):
        perform(world, Planner(), known(world), "1", BESIDE)
    assert world.pose(1).distance_m(before[1]) < 0.05
    assert at_home(world)


def test_only_the_fingers_touch_and_only_what_they_carry(world: ArmWorld) -> None:
    put(
        world,
        ("small", 0.45, -0.1, 0, 0.3),
        ("lego", 0.5, 0.1, 0, -0.2),
        ("small", 0.45, -0.16, 0, 0.3),
        ("lego", 0.58, 0.08, 0, 0.0),
    )
    body = Watched(world)
    perform(body, Planner(), known(world), "1", ON_THE_LARGE_ONE)
    touched = set().union(*body.touched)
    assert touched == {(finger, "1") for finger in panda.FINGERS}
    assert 20 < sum(map(bool, body.touched)) < len(body.touched)


def goal_unseen(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "7", BESIDE


def goal_covered(world: ArmWorld) -> tuple[str, Pose]:
    put(world, ("lego", 0.5, 0.1, 0, 0.0), ("small", 0.5, 0.1, 0.05, 0.0))
    return "1", BESIDE


def goal_far(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "1", Pose.upright(0.93, 0.0, 0.02)


HEMMED_IN = tuple(
    ("small", 0.5 + x, y, 0.0, 0.0)
    for x, y in ((0.048, 0.0), (-0.048, 0.0), (0.0, 0.048), (0.0, -0.048))
)
"""8 mm from a small block in the middle: a finger is thicker."""


def goal_out_of_a_gap(world: ArmWorld) -> tuple[str, Pose]:
    put(world, ("small", 0.5, 0.0, 0, 0.0), *HEMMED_IN)
    return "1", BESIDE


def goal_in_a_gap(world: ArmWorld) -> tuple[str, Pose]:
    put(world, ("small", 0.5, -0.2, 0, 0.0), *HEMMED_IN)
    return "1", Pose.upright(0.5, 0.0, 0.02)


def goal_without_support(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "1", Pose.upright(0.5, -0.2, 0.06)


def goal_without_room(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "1", Pose.upright(0.6, 0.042, 0.02)


def goal_unstable(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "1", Pose.upright(0.6, 0.025, 0.06)


@pytest.mark.parametrize(
    ("scene", "why", "words"),
    [
        (goal_unseen, Why.UNSEEN, ["7"]),
        (goal_covered, Why.COVERED, ["1", "2"]),
        (goal_far, Why.OUT_OF_REACH, ["1"]),
        (goal_out_of_a_gap, Why.NO_WAY, ["1", "finger"]),
        (goal_in_a_gap, Why.NO_WAY, ["1", "finger"]),
        (goal_without_support, Why.NO_SUPPORT, ["40 mm"]),
        (goal_without_room, Why.NO_ROOM, ["3"]),
        (goal_unstable, Why.UNSTABLE, ["3"]),
    ],
)
def test_what_can_not_be_done_is_refused_before_anything_moves(
    world: ArmWorld,
    scene: Callable[[ArmWorld], tuple[str, Pose]],
    why: Why,
    words: list[str],
) -> None:
    name, goal = scene(world)
    poses, joints = world.poses(), world.joints()
    with pytest.raises(RefusedError) as caught:
        perform(Still(world), Planner(), known(world), name, goal, keep=known(world)())
    assert caught.value.why is why
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert world.poses() == poses
    np.testing.assert_array_equal(world.joints(), joints)


class Snatched(Through):
    """The first time that the fingers close, the block has just been put elsewhere."""

    def __init__(self, world: ArmWorld, elsewhere: Pose) -> None:
        super().__init__(world)
        self._elsewhere: Pose | None = elsewhere

    def grip(self, opening_m: float, force_n: float) -> None:
        super().grip(opening_m, force_n)
        if opening_m == 0.0 and self._elsewhere is not None:
            self.world.place(1, self._elsewhere)
            self._elsewhere = None


ELSEWHERE = Pose.upright(0.42, -0.22, 0.02, 0.1)


def test_fingers_that_close_on_nothing_feel_it_and_the_arm_goes_home(world: ArmWorld) -> None:
    three(world)
    before = world.poses()
    carry = Planner().carry(known(world)(), "1", BESIDE, world.joints())
    marks: list[str] = []
    assert carry_out(Snatched(world, ELSEWHERE), carry, marks.append) is Done.NOT_GRASPED
    assert at_home(world)
    assert marks[0] == "reached" and "grasped" not in marks and "lifted" not in marks
    after = world.poses()
    assert after[1].distance_m(ELSEWHERE) < PLACED_M
    assert all(after[other].distance_m(before[other]) < STAYED_M for other in (2, 3))


@pytest.mark.parametrize("by_pictures", [False, True])
def test_a_block_that_was_snatched_is_grasped_where_it_is_then(
    world: ArmWorld, renderer: Renderer, by_pictures: bool
) -> None:
    three(world)
    look = pictured(world, renderer) if by_pictures else known(world)
    body, planner = Snatched(world, ELSEWHERE), Noting()
    performed = perform(body, planner, look, "1", ON_THE_LARGE_ONE)
    assert performed.tries == 2 and "try 2" in str(performed)
    first, second = planner.carries
    assert math.dist(second.grasp.hand.position[:2], ELSEWHERE.position[:2]) < 0.002
    assert performed.motion_s == pytest.approx(first.duration_s + second.duration_s)
    assert world.pose(1).distance_m(second.placement.cuboid.pose) < 2 * PLACED_M
    assert at_home(world)


class Numb(Through):
    """Its fingers never close."""

    def grip(self, opening_m: float, force_n: float) -> None:
        super().grip(max(opening_m, 0.055), force_n)


def test_a_grasp_that_always_fails_ends_after_a_few_tries(world: ArmWorld) -> None:
    three(world)
    before, planner = world.poses(), Noting()
    marks: list[str] = []
    with pytest.raises(FailedError, match="1") as caught:
        perform(Numb(world), planner, known(world), "1", BESIDE, marks.append)
    assert Done.NOT_GRASPED.value in str(caught.value) and str(MAX_TRIES) in str(caught.value)
    assert len(planner.carries) == marks.count("reached") == MAX_TRIES
    assert at_home(world)
    after = world.poses()
    assert all(after[number].distance_m(before[number]) < STAYED_M for number in before)


def test_an_arm_that_began_elsewhere_ends_in_the_ready_pose_whatever_happens(
    world: ArmWorld,
) -> None:
    three(world)
    joints = above(0.4, 0.2, 0.25)
    for _ in range(1500):
        world.drive(joints, np.zeros(panda.JOINTS))
        world.tick()
    assert not at_home(world)
    carry = Planner().carry(known(world)(), "1", BESIDE, world.joints())
    assert carry_out(Numb(world), carry) is Done.NOT_GRASPED
    assert at_home(world)


class Jolted(Through):
    """So many ticks after an event the fingers open for a moment; `times` times in all."""

    OPEN_TICKS = 80

    def __init__(self, world: ArmWorld, event: str, after_ticks: int, times: int) -> None:
        super().__init__(world)
        self._event, self._after_ticks, self._times = event, after_ticks, times
        self._ticks: int | None = None
        self.marks: list[str] = []

    def mark(self, event: str) -> None:
        """Is told what is done."""
        self.marks.append(event)
        if event == self._event and self._times:
            self._times -= 1
            self._ticks = 0

    def tick(self) -> None:
        super().tick()
        if self._ticks is None:
            return
        self._ticks += 1
        if self._ticks == self._after_ticks:
            self.world.grip(0.07, 20.0)
        elif self._ticks == self._after_ticks + self.OPEN_TICKS:
            self.world.grip(0.0, 20.0)
            self._ticks = None


ACROSS = Pose.upright(0.62, 0.2, 0.02)


@pytest.mark.parametrize(("event", "after_ticks"), [("grasped", 100), ("lifted", 60)])
def test_a_block_that_is_knocked_out_of_the_hand_is_missed(
    world: ArmWorld, event: str, after_ticks: int
) -> None:
    three(world)
    before = world.poses()
    carry = Planner().carry(known(world)(), "1", ACROSS, world.joints())
    body = Jolted(world, event, after_ticks, 1)
    assert carry_out(body, carry, body.mark) is Done.SLIPPED
    # With nothing in the hand, nothing is put down.
    assert "let go" not in body.marks
    assert at_home(world) and world.settle().at_rest
    after = world.poses()
    assert after[1].distance_m(ACROSS) > 0.05 and after[1].position[2] < 0.03
    assert all(after[other].distance_m(before[other]) < STAYED_M for other in (2, 3))


@pytest.mark.parametrize(
    ("event", "after_ticks", "times"),
    [("grasped", 100, 1), ("lifted", 60, 2), ("above", 20, 1)],
)
def test_one_that_was_knocked_out_is_fetched_where_it_fell(
    world: ArmWorld, renderer: Renderer, event: str, after_ticks: int, times: int
) -> None:
    three(world)
    body, planner = Jolted(world, event, after_ticks, times), Noting()
    performed = perform(body, planner, pictured(world, renderer), "1", ACROSS, body.mark)
    assert performed.tries == len(planner.carries) == body.marks.count("reached") == times + 1
    assert world.pose(1).distance_m(ACROSS) < 0.002
    assert at_home(world)


def test_one_that_is_always_knocked_out_is_given_up(world: ArmWorld, renderer: Renderer) -> None:
    three(world)
    body, planner = Jolted(world, "lifted", 60, 100), Noting()
    with pytest.raises(FailedError, match="1") as caught:
        perform(body, planner, pictured(world, renderer), "1", ACROSS, body.mark)
    assert Done.SLIPPED.value in str(caught.value) and str(MAX_TRIES) in str(caught.value)
    assert len(planner.carries) == body.marks.count("reached") == MAX_TRIES
    assert at_home(world)


@pytest.mark.parametrize("after_ticks", [120, 200, 280])
def test_one_that_falls_among_others_is_fetched_or_given_up_in_words(
    world: ArmWorld, renderer: Renderer, after_ticks: int
) -> None:
    """Leaning on another, it may not even be seen as a block of its own."""
    three(world)
    body, planner = Jolted(world, "lifted", after_ticks, 1), Noting()
    try:
        performed = perform(body, planner, pictured(world, renderer), "1", ACROSS, body.mark)
    except FailedError as failure:
        assert Done.SLIPPED.value in str(failure)
    else:
        assert performed.tries > 1 and performed.miss_m < 0.005
        assert world.pose(1).distance_m(ACROSS) < 0.005
    assert 1 <= len(planner.carries) == body.marks.count("reached") <= MAX_TRIES
    assert at_home(world)


def carried() -> str:
    """The poses of all blocks and the joints after a carrying, to the last bit."""
    with closing(ArmWorld()) as world:
        three(world)
        perform(world, Planner(), known(world), "1", ON_THE_LARGE_ONE)
        return f"{world.poses()!r} {world.joints().tolist()!r}"


def test_the_same_carrying_in_another_process_ends_in_the_same_bytes() -> None:
    paths = os.pathsep.join([str(TESTS.parent), str(TESTS)])
    done = subprocess.run(
        [sys.executable, "-c", "import test_arm_carry; print(test_arm_carry.carried())"],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == carried()
