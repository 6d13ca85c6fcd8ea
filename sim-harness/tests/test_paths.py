"""Paths of the arm around obstacles."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from arm_scenes import KINEMATICS, above
from world_scenes import DOMAIN

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.panda import READY_RAD as READY
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation import paths
from nsrm_harness.manipulation.collision import CollisionChecker, Nearest, steps
from nsrm_harness.manipulation.execute import ExecutionResult, execute
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.blocks import block_from_attributes


def around(objects: Mapping[str, Cuboid], held: Cuboid | None = None) -> Any:
    """From one side of the work space to the other."""
    checker = CollisionChecker(KINEMATICS, objects, held)
    return paths.free(checker, above(0.5, -0.2, 0.15), above(0.5, 0.2, 0.15), 0.04, 0.8)


TOWER = {"tower": Cuboid(Pose((0.5, 0.0, 0.125)), (0.06, 0.06, 0.25))}
IN_HAND = Cuboid(Pose((0.0, 0.0, panda.FINGERTIP_M)), (0.04, 0.04, 0.04))


@pytest.mark.parametrize("held", [None, IN_HAND])
def test_there_is_a_way_around_a_tower(held: Cuboid | None) -> None:
    (straight,) = around({}, held)
    checker = CollisionChecker(KINEMATICS, TOWER, held)
    touch = checker.along(straight, 0.04)
    assert touch is not None and "tower" in touch.pair
    moves = around(TOWER, held)
    assert isinstance(moves, list) and len(moves) > 1
    np.testing.assert_array_equal(moves[0].begin, straight.begin)
    np.testing.assert_array_equal(moves[-1].end, straight.end)
    for one, following in itertools.pairwise(moves):
        np.testing.assert_array_equal(one.end, following.begin)
    # Finer than it was looked at when it was found.
    for move in moves:
        for joints in steps(move, 0.0015).joints:
            assert checker.touches(joints, 0.04, 1e-4) is None
    # The same ones again, whatever was planned before.
    around({"tower": Cuboid(Pose((0.5, 0.05, 0.125)), (0.06, 0.06, 0.25))}, held)
    again = around(TOWER, held)
    assert [move.begin.tolist() for move in again] == [move.begin.tolist() for move in moves]


def test_a_carrying_goes_around_a_tower_with_and_without_the_block() -> None:
    block = Cuboid(Pose((0.5, -0.2, 0.02)), (0.04, 0.04, 0.04))
    goal, begin = Pose((0.5, 0.2, 0.02)), above(0.5, 0.2, 0.12)
    carry = PickAndPlacePlanner().carry({"block": block, **TOWER}, "block", goal, begin)
    in_hand = Cuboid(carry.grasp.hand.inverse() @ block.pose, block.edges_m)
    for parts, held in ((carry.reach, None), (carry.transfer, in_hand)):
        checker = CollisionChecker(KINEMATICS, TOWER, held)
        straight = paths.Straight(parts[0].begin, parts[-1].end)
        touch = checker.along(straight, panda.MAX_OPENING_M)
        assert touch is not None and "tower" in touch.pair
        assert len(parts) > 1
        assert all(checker.along(part, panda.MAX_OPENING_M) is None for part in parts)
    # Each motion begins where the one before it ends.
    whole = (*carry.reach, carry.descend, carry.lift, *carry.transfer, carry.lower, carry.retreat)
    np.testing.assert_array_equal(whole[0].begin, begin)
    for one, following in itertools.pairwise((*whole, *carry.home)):
        np.testing.assert_allclose(one.end, following.begin, atol=1e-9)
    np.testing.assert_array_equal(carry.home[-1].end, panda.READY_RAD)


def test_where_there_is_no_way_it_is_told_what_stands_in_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wall = {"wall": Cuboid(Pose((0.5, 0.0, 0.6)), (1.4, 0.02, 1.18))}
    monkeypatch.setattr(paths, "MAX_CHECKS", 100)
    touch = around(wall)
    assert isinstance(touch, Nearest) and "wall" in touch.pair
    # At an end already.
    on_it = {"block": Cuboid(Pose((0.5, 0.2, 0.075)), (0.1, 0.1, 0.15))}
    touch = around(on_it)
    assert isinstance(touch, Nearest) and "block" in touch.pair


def test_a_hand_that_would_touch_a_tower_leans_away_from_it() -> None:
    high, small = (0.06, 0.06, 0.05), (0.04, 0.04, 0.04)
    tower = {f"tower {n}": Cuboid(Pose.upright(0.5, 0.0, 0.025 + 0.05 * n), high) for n in range(4)}
    blocks = [block_from_attributes(DOMAIN, {"color": "red", "size": "lego"})] * 4
    blocks.append(block_from_attributes(DOMAIN, {"color": "blue", "size": "small"}))
    beside, goal = Pose.upright(0.5, 0.075, 0.02), Pose.upright(0.5, 0.2, 0.02)
    carry = PickAndPlacePlanner().carry(
        {"block": Cuboid(beside, small), **tower}, "block", goal, READY
    )
    assert carry.grasp.lean_rad != 0.0
    lean = math.acos(float(-carry.grasp.hand.rotation()[2, 2]))
    assert lean == pytest.approx(abs(carry.grasp.lean_rad))
    # Without the tower it does not.
    alone = PickAndPlacePlanner().carry({"block": Cuboid(beside, small)}, "block", goal, READY)
    assert alone.grasp.lean_rad == 0.0
    with closing(ArmWorld()) as world:
        world.spawn(blocks, [*(cuboid.pose for cuboid in tower.values()), beside])
        assert world.settle().at_rest
        before = world.poses()
        assert execute(world, carry) is ExecutionResult.PLACED
        after = world.poses()
        assert all(after[number].distance_m(before[number]) < 0.0005 for number in range(1, 5))
        assert after[5].distance_m(goal) < 0.001
