"""A stopped arm brakes along its path, keeps what it holds, and finds its way back."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from arm_scenes import KINEMATICS
from world_scenes import DOMAIN

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.execute import execute, retreat
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlace, PickAndPlacePlanner
from nsrm_harness.manipulation.robot_interface import wait
from nsrm_harness.manipulation.stopping import (
    BACK_RAD,
    Braking,
    PathPart,
    StoppedError,
    reversed_from,
)
from nsrm_harness.manipulation.trajectory import Backwards, Trajectory
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.blocks import block_from_attributes

GOAL = Pose.upright(0.62, 0.15, 0.02, 0.7)
BRAKED_S = 1.2
TICK_S = 1 / 240
STAYED_M = 0.0015
HOME_RAD = 0.01

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        blocks = [
            block_from_attributes(DOMAIN, {"color": color, "size": "small"})
            for color in ("red", "blue")
        ]
        made.spawn(blocks, [Pose.upright(0.42, -0.15, 0.02, 0.3), Pose.upright(0.42, 0.2, 0.02)])
        assert made.settle().at_rest
        yield made


def planned(world: ArmWorld) -> PickAndPlace:
    objects = {str(each.id): Cuboid(each.pose, each.block.edges_m) for each in world.placed()}
    return PickAndPlacePlanner().carry(objects, "1", GOAL, world.joints())


def all_trajectories(carry: PickAndPlace) -> list[Trajectory]:
    trajectories = [*carry.reach, carry.descend, carry.lift, *carry.transfer]
    return [*trajectories, carry.lower, carry.retreat, *carry.home]


def off_path_rad(joints: Joints, trajectory: Trajectory) -> float:
    """From each of some joints `[n, 7]` to the nearest on a trajectory, at most."""
    path = trajectory.at(np.linspace(0.0, trajectory.duration_s, 2000)).joints
    return max(float(np.abs(path - each).max(axis=1).min()) for each in joints)


def test_braking_and_going_on_keep_to_the_path_and_the_makers_limits(world: ArmWorld) -> None:
    longest_s = 0.0
    for trajectory in all_trajectories(planned(world)):
        for since_s in np.linspace(0.0, trajectory.duration_s, 9):
            braking = Braking(trajectory, float(since_s))
            longest_s = max(longest_s, braking.duration_s)
            first = trajectory.at(np.array([since_s]))
            stopped_s = braking.stopped_s
            assert since_s <= stopped_s <= trajectory.duration_s
            parts = [
                braking,
                PathPart(trajectory, stopped_s, 0.0),
                PathPart(trajectory, stopped_s, trajectory.duration_s),
            ]
            for part in parts:
                moments = part.at(np.arange(0.0, part.duration_s + TICK_S, TICK_S))
                assert off_path_rad(moments.joints, trajectory) < 0.002
                assert (np.abs(moments.speeds) <= panda.MAX_SPEED_RAD_S).all()
                limits = panda.MAX_ACCELERATION_RAD_S2
                assert (np.abs(moments.accelerations) <= limits).all()
                np.testing.assert_allclose(moments.speeds[-1], 0.0, atol=1e-6)
                # Speeds are those of the joints.
                moved = np.diff(moments.joints, axis=0) / TICK_S
                between = (moments.speeds[1:] + moments.speeds[:-1]) / 2
                np.testing.assert_allclose(moved, between, atol=0.02)
            starts = [part.at(np.array([0.0])) for part in parts]
            np.testing.assert_allclose(starts[0].joints, first.joints, atol=1e-9)
            np.testing.assert_allclose(starts[0].speeds, first.speeds, atol=1e-9)
            ends = [part.at(np.array([part.duration_s])).joints[0] for part in parts]
            for start in starts[1:]:
                np.testing.assert_allclose(start.joints[0], ends[0], atol=1e-9)
            np.testing.assert_allclose(ends[1], trajectory.begin, atol=1e-5)
            np.testing.assert_allclose(ends[2], trajectory.end, atol=1e-5)
    assert 0.1 < longest_s < BRAKED_S


@pytest.mark.parametrize("pushed_rad", [0.0, 0.0025])
def test_back_from_what_was_met_it_goes_where_it_has_been_looked_at(
    world: ArmWorld, pushed_rad: float
) -> None:
    rng = np.random.default_rng(5)
    carry = planned(world)
    for trajectory in (carry.descend, carry.lower, Backwards(carry.lift)):
        for share in np.linspace(0.0, 1.0, 11):
            on_it = trajectory.at(np.array([share * trajectory.duration_s])).joints[0]
            joints = on_it + pushed_rad * rng.choice((-1.0, 1.0), panda.JOINTS)
            onto, along = reversed_from(joints, trajectory)
            np.testing.assert_array_equal(onto.begin, joints)
            np.testing.assert_allclose(onto.end, along.begin, atol=1e-9)
            np.testing.assert_allclose(along.end, trajectory.begin, atol=1e-5)
            # Not on towards what was met, and by no large piece beside its path.
            heights = [KINEMATICS.hand(each).position[2] for each in (on_it, onto.end, along.end)]
            assert (np.diff(heights) >= -1e-9).all()
            assert float(np.abs(onto.end - joints).max()) < 2 * BACK_RAD
            for part, most_rad in ((onto, pushed_rad + 1e-3), (along, 1e-3)):
                moments = part.at(np.arange(0.0, part.duration_s + TICK_S, TICK_S))
                assert off_path_rad(moments.joints, trajectory) < most_rad
                assert (np.abs(moments.speeds) <= panda.MAX_SPEED_RAD_S).all()
            # It has left what it has met, unless it has hardly begun.
            begun_rad = float(np.abs(trajectory.begin - joints).max())
            assert float(np.abs(onto.end - joints).max()) >= min(BACK_RAD, begun_rad) - 1e-5


MOMENTS = [
    # Behind which mark, after how many ticks, and whether the block is held then.
    ("", 100, False),
    ("reached", 5, True),
    ("grasped", 60, True),
    ("lifted", 80, True),
    ("above", 40, True),
    ("let go", 60, False),
]


@pytest.mark.parametrize(("event", "ticks", "held"), MOMENTS)
def test_it_stands_still_and_then_goes_back(
    world: ArmWorld, event: str, ticks: int, held: bool
) -> None:
    carry = planned(world)
    before = world.poses()
    # Ticks since the event, once it has come.
    since: list[int] = [] if event else [0]
    stopped_at_s: list[float] = []

    def mark(done: str) -> None:
        if done == event:
            since.append(0)

    def tick() -> None:
        if since:
            since[0] += 1

    def stop() -> bool:
        wanted = bool(since) and since[0] >= ticks
        if wanted and not stopped_at_s:
            stopped_at_s.append(world.time_s)
        return wanted

    world.on_tick = tick
    with pytest.raises(StoppedError, match="stands still") as caught:
        execute(world, carry, mark, stop)
    assert world.time_s - stopped_at_s[0] < BRAKED_S
    joints, pose = world.joints(), world.pose(1)
    wait(world, 1.0)
    np.testing.assert_allclose(world.joints(), joints, atol=2e-3)
    assert world.pose(1).distance_m(pose) < STAYED_M
    is_held = world.opening_m() < carry.grasp.opening_m - 0.002
    assert is_held == held
    retreat(world, caught.value.back)
    assert float(np.abs(world.joints() - panda.READY_RAD).max()) < HOME_RAD
    where = carry.placement.cuboid.pose if event == "let go" else before[1]
    assert world.pose(1).distance_m(where) < STAYED_M
    assert world.pose(2).distance_m(before[2]) < STAYED_M


def test_a_stop_on_the_way_back_is_one_too(world: ArmWorld) -> None:
    carry = planned(world)
    before = world.pose(1)
    count = 0

    def after(ticks: int) -> bool:
        nonlocal count
        count += 1
        return count > ticks

    heights = []
    with pytest.raises(StoppedError) as caught:
        # In the middle of the transfer.
        first = (*carry.reach, carry.descend, carry.lift)
        length_s = sum(trajectory.duration_s for trajectory in first)
        ticks = round((length_s + carry.transfer[0].duration_s / 2) / world.tick_s)
        execute(world, carry, stop=lambda: after(ticks))
    back = caught.value.back
    for _ in range(3):
        heights.append(world.pose(1).position[2])
        count = 0
        with pytest.raises(StoppedError) as caught:
            retreat(world, back, stop=lambda: after(300))
        back = caught.value.back
    assert min(heights) > 0.05
    retreat(world, back)
    assert world.pose(1).distance_m(before) < STAYED_M
    assert float(np.abs(world.joints() - panda.READY_RAD).max()) < HOME_RAD
