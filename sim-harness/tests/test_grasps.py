"""Grasps of a block among neighbours: at the middle of its faces if there is room, off the middle
if a neighbour stands in front of a part of a face, and with fingers that open less if neighbours
leave no more room."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import pytest
from arm_scenes import PLACED_M, STAYED_M, Noting, known, put

from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.grasps import CLEAR_M, NARROW_M
from nsrm_harness.manipulation.retries import reach_sub_goal
from nsrm_harness.simulation.arm_world import ArmWorld

GOAL = Pose.upright(0.5, -0.2, 0.02)
Neighbours = tuple[tuple[float, float], ...]

FREE: Neighbours = ()
BEFORE_HALF: Neighbours = ((0.025, 0.054), (0.025, -0.054), (0.05, 0.0), (-0.05, 0.0))
"""Before one half of two faces of a small block, and before all of the others."""
AROUND: Neighbours = ((0.062, 0.0), (-0.062, 0.0), (0.0, 0.062), (0.0, -0.062))
"""22 mm from each face."""


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


@pytest.mark.parametrize(
    ("neighbours", "is_aside", "clear_m"),
    [(FREE, False, CLEAR_M), (BEFORE_HALF, True, CLEAR_M), (AROUND, False, NARROW_M)],
)
def test_a_block_is_held_where_its_neighbours_leave_room(
    world: ArmWorld, neighbours: Neighbours, is_aside: bool, clear_m: float
) -> None:
    put(world, *(("small", 0.5 + x, 0.05 + y, 0.0, 0.0) for x, y in ((0.0, 0.0), *neighbours)))
    before = world.poses()
    planner = Noting()
    performed = reach_sub_goal(world, planner, known(world), "1", GOAL)
    assert performed.tries == 1 and performed.cleared == ()
    (carry,) = planner.carries
    held_m = (before[1].inverse() @ carry.grasp.hand).position
    assert (max(map(abs, held_m[:2])) > 0.005) == is_aside
    assert carry.grasp.clear_m == clear_m
    assert world.pose(1).distance_m(carry.placement.cuboid.pose) < PLACED_M
    for other in before.keys() - {1}:
        assert world.pose(other).distance_m(before[other]) < STAYED_M
