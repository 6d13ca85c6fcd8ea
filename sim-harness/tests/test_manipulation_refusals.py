"""Infeasible sub-goals are refused before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing

import numpy as np
import pytest
from arm_scenes import (
    BESIDE,
    HEMMED_IN,
    Still,
    known,
    put,
    three,
)

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.grasps import LOWEST_M, WIDEST_M, grasps, why_not_held
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ExecutionOptions, reach_sub_goal
from nsrm_harness.simulation.arm_world import ArmWorld

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


def goal_unseen(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "7", BESIDE


def goal_covered(world: ArmWorld) -> tuple[str, Pose]:
    put(world, ("lego", 0.5, 0.1, 0, 0.0), ("small", 0.5, 0.1, 0.05, 0.0))
    return "1", BESIDE


def goal_far(world: ArmWorld) -> tuple[str, Pose]:
    three(world)
    return "1", Pose.upright(0.93, 0.0, 0.02)


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
        (goal_unseen, RefusalReason.UNSEEN, ["7"]),
        (goal_covered, RefusalReason.COVERED, ["1", "2"]),
        (goal_far, RefusalReason.OUT_OF_REACH, ["1"]),
        (goal_out_of_a_gap, RefusalReason.NO_PATH, ["1", "finger"]),
        (goal_in_a_gap, RefusalReason.NO_PATH, ["1", "finger"]),
        (goal_without_support, RefusalReason.NO_SUPPORT, ["40 mm"]),
        (goal_without_room, RefusalReason.NO_ROOM, ["3"]),
        (goal_unstable, RefusalReason.UNSTABLE, ["3"]),
    ],
)
def test_what_can_not_be_done_is_refused_before_anything_moves(
    world: ArmWorld,
    scene: Callable[[ArmWorld], tuple[str, Pose]],
    why: RefusalReason,
    words: list[str],
) -> None:
    name, goal = scene(world)
    poses, joints = world.poses(), world.joints()
    with pytest.raises(RefusedError) as caught:
        reach_sub_goal(
            Still(world),
            PickAndPlacePlanner(),
            known(world),
            name,
            goal,
            ExecutionOptions(keep=known(world)()),
        )
    assert caught.value.why is why
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert world.poses() == poses
    np.testing.assert_array_equal(world.joints(), joints)


@pytest.mark.parametrize(
    ("edges_mm", "words"),
    [
        ((90.0, 85.0, 50.0), ["85.0 mm wide", "77.0 mm at most"]),
        ((40.0, 40.0, 15.0), ["15.0 mm high", "need 20.0 mm"]),
        ((80.0, 80.0, 10.0), ["80.0 mm wide", "10.0 mm high"]),
    ],
)
def test_a_block_that_no_hand_can_hold_is_refused_with_its_measures(
    edges_mm: tuple[float, float, float], words: list[str]
) -> None:
    a, b, height = (edge / 1000 for edge in edges_mm)
    block = Cuboid(Pose.upright(0.5, 0.1, height / 2), (a, b, height))
    goal = Pose.upright(0.5, -0.1, height / 2)
    with pytest.raises(RefusedError, match="the hand cannot hold block") as caught:
        PickAndPlacePlanner().carry({"block": block}, "block", goal, panda.READY_RAD)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert "reach" not in str(caught.value)


def test_why_a_block_is_not_held_is_told_of_those_without_a_grasp_alone() -> None:
    less = (1e-4, -1e-4)
    for wide, high in ((wide, high) for wide in less for high in less):
        edges = (WIDEST_M - wide, 0.1, LOWEST_M + high)
        block = Cuboid(Pose.upright(0.5, 0.0, edges[2] / 2), edges)
        assert bool(grasps(block)) == (why_not_held(block) == "") == (wide > 0 and high > 0)
