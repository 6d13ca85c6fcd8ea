"""Blocks are moved by friction, within the manufacturer's limits, and without other contacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from arm_scenes import (
    BESIDE,
    KINEMATICS,
    ON_THE_LARGE_ONE,
    PLACED_M,
    STAYED_M,
    Noting,
    Through,
    at_home,
    known,
    pictured,
    put,
    three,
)

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.collision import CollisionChecker
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, reach_sub_goal
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.bullet import pybullet
from nsrm_harness.simulation.render import Renderer

PLACED_RAD = math.radians(3)

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


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
    performed = reach_sub_goal(body, planner, look, "1", goal)
    assert performed.name == "1" and performed.tries == 1 and performed.shifted == ()
    (carry,) = planner.carries
    target, after = carry.placement.cuboid.pose, world.poses()
    # What is held is held as it was seen: its error goes with it.
    seen_m = 0.001 if by_pictures else 0.0
    assert after[1].distance_m(target) < PLACED_M + seen_m
    assert after[1].angle_rad(target) < PLACED_RAD
    # It is square: a quarter turn cannot be seen.
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
        carry = PickAndPlacePlanner().carry({"block": block}, "block", goal, panda.READY_RAD)
        target = carry.placement.cuboid
        assert target.edges_m == edges_m
        assert target.pose.distance_m(goal) < 1e-9
        assert abs(turn_rad(goal, target.pose, same_rad)) < 1e-9
        turned = turn_rad(block.pose, target.pose, 2 * math.pi)
        assert abs(turned) <= same_rad / 2 + 1e-9


def test_a_block_is_not_turned_the_long_way_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """Turned by 270° it would look as if by -90°."""
    large, small = (0.06, 0.06, 0.05), (0.04, 0.04, 0.04)
    objects = {
        "white": Cuboid(Pose.upright(0.4833, 0.0868, 0.025, 0.0024), large),
        "cyan on it": Cuboid(Pose.upright(0.4833, 0.0868, 0.075, -0.0024), large),
        "red": Cuboid(Pose.upright(0.5642, 0.1730, 0.020, 0.0943), small),
        "blue": Cuboid(Pose.upright(0.3971, -0.0284, 0.025, 0.1431), large),
        "yellow": Cuboid(Pose.upright(0.6325, 0.2034, 0.025, -0.1154), large),
    }
    beside_blue = Pose((0.3971, 0.0465, 0.02))

    def turned_rad() -> float:
        carry = PickAndPlacePlanner().carry(objects, "red", beside_blue, panda.READY_RAD)
        yaws = [
            KINEMATICS.hand(joints).yaw_rad()
            for trajectory in carry.transfer
            for joints in trajectory.at(np.linspace(0.0, trajectory.duration_s, 200)).joints
        ]
        return float(np.ptp(np.unwrap(yaws)))

    assert turned_rad() < math.radians(120)
    monkeypatch.setattr("nsrm_harness.manipulation.pick_and_place.MAX_TURN_RAD", math.inf)
    assert turned_rad() > math.radians(270)


def test_the_fingers_keep_clear_of_the_block_before_and_after_the_vertical_motions() -> None:
    """Tilted between its neighbours, the hand would swing down through the block that it has just
    put on the stack."""
    objects = {
        "white": Cuboid(Pose.upright(0.43727, 0.08191, 0.02523, -0.07528), (0.06067, 0.06, 0.0505)),
        "cyan": Cuboid(Pose.upright(0.43671, 0.08232, 0.07022, 0.00072), (0.0409, 0.0401, 0.0395)),
        "magenta": Cuboid(
            Pose.upright(0.44236, 0.18604, 0.025, -0.13074), (0.06091, 0.06009, 0.04999)
        ),
        "next to it": Cuboid(
            Pose.upright(0.50756, 0.19341, 0.01999, -0.07588), (0.04084, 0.04013, 0.03999)
        ),
    }
    on_cyan = Pose.upright(0.43732, 0.08249, 0.11538, 0.0)
    carry = PickAndPlacePlanner().carry(objects, "magenta", on_cyan, panda.READY_RAD)
    before = CollisionChecker(KINEMATICS, objects)
    after = CollisionChecker(KINEMATICS, {**objects, "magenta": carry.placement.cuboid})
    for checker, path in ((before, carry.reach), (before, carry.back), (after, carry.home)):
        for segment in path:
            assert checker.along(segment, carry.grasp.opening_m) is None


def test_the_arm_is_driven_and_turns_within_the_makers_limits(world: ArmWorld) -> None:
    three(world)
    body = Watched(world)
    reach_sub_goal(body, PickAndPlacePlanner(), known(world), "1", ON_THE_LARGE_ONE)
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
    reach_sub_goal(world, PickAndPlacePlanner(), known(world), "1", ON_THE_LARGE_ONE)
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
    with pytest.raises(ManipulationError):
        reach_sub_goal(world, PickAndPlacePlanner(), known(world), "1", BESIDE)
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
    reach_sub_goal(body, PickAndPlacePlanner(), known(world), "1", ON_THE_LARGE_ONE)
    touched = set().union(*body.touched)
    assert touched == {(finger, "1") for finger in panda.FINGERS}
    assert 20 < sum(map(bool, body.touched)) < len(body.touched)
