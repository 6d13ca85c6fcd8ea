"""A refused pick and place gives the right reason, and remedies for that reason are tried."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import closing

import pytest
from arm_scenes import PLACED_M, STAYED_M, at_home, known, put

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.manipulation import pick_and_place
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.grasps import HOLDS, UPRIGHT
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import reach_sub_goal
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.blocks import Block

LONG: Vector3 = (0.05, 0.09, 0.05)
"""The hand holds it by one pair of its faces alone."""
NEAR_THE_BASE = Pose.upright(0.154, 0.292, 0.025, 2.526)
FAR_AND_TURNED = Pose.upright(0.71, 0.215, 0.025, -1.765)
"""With the hand at the block's middle, joint 7 gets there the long way round alone."""
ONE_LEAN = Pose.upright(0.257, 0.086, 0.025, 2.771)
OTHER_LEAN = Pose.upright(0.844, 0.214, 0.025, -1.088)
"""The hand leans towards the arm there, and away from it here."""

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


def refusal(objects: Mapping[str, Cuboid], name: str, goal: Pose) -> RefusedError:
    with pytest.raises(RefusedError) as caught:
        PickAndPlacePlanner().carry(objects, name, goal, panda.READY_RAD)
    return caught.value


def put_long(world: ArmWorld, pose: Pose) -> None:
    world.spawn([Block((), LONG, (1.0, 0.0, 0.0))], [pose])
    assert world.settle().at_rest


def set_down_on_the_way(world: ArmWorld, goal: Pose) -> None:
    """It is, and is where it was to go in the end."""
    performed = reach_sub_goal(world, PickAndPlacePlanner(), known(world), "1", goal)
    assert [name for name, _ in performed.cleared] == ["1"]
    assert "set down on the way" in str(performed)
    assert world.pose(1).distance_m(goal) < PLACED_M and at_home(world)


def test_what_turns_too_far_is_refused_for_that_and_set_down_on_the_way(
    world: ArmWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pick_and_place, "HOLDS", HOLDS[:1])
    put_long(world, NEAR_THE_BASE)
    why = refusal(known(world)(), "1", FAR_AND_TURNED)
    assert why.why is RefusalReason.NO_PATH and why.in_the_way == ()
    assert "turns it by 294°, and 120° are allowed" in str(why) and "reach" not in str(why)
    set_down_on_the_way(world, FAR_AND_TURNED)


def test_what_the_way_turns_around_is_moved_aside(
    world: ArmWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Around the tower the block is turned, straight over the lower half of it not at all."""
    monkeypatch.setattr(pick_and_place, "HOLDS", HOLDS[:1])
    monkeypatch.setattr(pick_and_place, "LEANS_RAD", UPRIGHT)
    monkeypatch.setattr(pick_and_place, "MAX_TURN_RAD", math.radians(1.0))
    put(
        world,
        ("small", 0.5, -0.16, 0.0, 0.0),
        ("lego", 0.52, 0.0, 0.0, 0.0),
        ("lego", 0.52, 0.0, 0.05, 0.0),
    )
    goal = Pose.upright(0.5, 0.16, 0.02)
    why = refusal(known(world)(), "1", goal)
    assert why.why is RefusalReason.NO_PATH and why.in_the_way == ("3",)
    assert "1° are allowed; straight there, 3 would" in str(why)
    lower = world.pose(2)
    performed = reach_sub_goal(world, PickAndPlacePlanner(), known(world), "1", goal)
    ((name, place),) = performed.cleared
    assert name == "3" and world.pose(3).distance_m(place) < PLACED_M
    assert world.pose(1).distance_m(goal) < PLACED_M
    assert world.pose(2).distance_m(lower) < STAYED_M and at_home(world)


def test_what_no_hold_reaches_at_both_ends_is_set_down_on_the_way(world: ArmWorld) -> None:
    put_long(world, ONE_LEAN)
    why = refusal(known(world)(), "1", OTHER_LEAN)
    assert why.why is RefusalReason.NO_PATH and why.in_the_way == ()
    assert "no grasp reaches both" in str(why)
    set_down_on_the_way(world, OTHER_LEAN)


@pytest.mark.parametrize(
    ("begin", "goal", "words"),
    [
        ((0.5, 0.0), (0.95, 0.0), "does not reach the sub-goal of block from above"),
        ((0.95, 0.0), (0.5, 0.0), "does not reach block from above"),
        ((0.95, 0.0), (0.95, 0.2), "does not reach block from above"),
    ],
)
def test_what_is_out_of_reach_is_said(
    begin: tuple[float, float], goal: tuple[float, float], words: str
) -> None:
    objects = {"block": Cuboid(Pose.upright(*begin, 0.02), (0.04, 0.04, 0.04))}
    why = refusal(objects, "block", Pose.upright(*goal, 0.02))
    assert why.why is RefusalReason.OUT_OF_REACH and words in str(why)
