"""A block that needs another grasp at its goal is set down on the way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing

import pytest
from arm_scenes import PLACED_M, STAYED_M, Numb, Still, at_home, known, put
from test_relocation import Endless

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.regrasp import plan_regrasp
from nsrm_harness.manipulation.retries import ExecutionOptions, ManipulationError, reach_sub_goal
from nsrm_harness.simulation.arm_world import ArmWorld

LEFT, RIGHT = Pose.upright(0.42, 0.093, 0.02), Pose.upright(0.42, 0.217, 0.02)
"""Of the tower: a hand must lean away from it to reach between, the one way and the other."""
TOWER = ("2", "3", "4")
FREE = Pose.upright(0.6, -0.1, 0.02)

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        put(
            made,
            ("small", 0.42, 0.217, 0.0, 0.0),
            ("small", 0.42, 0.155, 0.0, 0.0),
            ("lego", 0.42, 0.155, 0.04, 0.0),
            ("lego", 0.42, 0.155, 0.09, 0.0),
        )
        yield made


def objects(world: ArmWorld) -> Mapping[str, Cuboid]:
    return known(world)()


def test_a_hand_that_leans_one_way_at_each_end_takes_two_turns(world: ArmWorld) -> None:
    before = world.poses()
    with pytest.raises(RefusedError) as caught:
        PickAndPlacePlanner().carry(objects(world), "1", LEFT, world.joints())
    assert caught.value.why is RefusalReason.NO_PATH
    marks: list[str] = []
    performed = reach_sub_goal(
        world,
        PickAndPlacePlanner(),
        known(world),
        "1",
        LEFT,
        ExecutionOptions(mark=marks.append, keep=TOWER),
    )
    after = world.poses()
    ((name, place),) = performed.cleared
    # Whoever now stands nearest to that place was not to be moved.
    assert performed.aside == []
    assert name == "1" and place.distance_m(LEFT) > PLACED_M
    assert after[1].distance_m(LEFT) < PLACED_M + performed.corrected_m
    assert all(after[number].distance_m(before[number]) < STAYED_M for number in (2, 3, 4))
    assert marks.count("grasped") == 2 and at_home(world)
    assert "; 1 was set down on the way, to be regrasped" in str(performed)


def test_from_there_it_can_be_carried_on_and_each_time_it_is_the_same(world: ArmWorld) -> None:
    seen, ready = objects(world), panda.READY_RAD
    why = RefusedError(RefusalReason.NO_PATH, "")
    ((name, place),) = plan_regrasp(PickAndPlacePlanner(), seen, "1", LEFT, ready, why)
    assert ((name, place),) == plan_regrasp(PickAndPlacePlanner(), seen, "1", LEFT, ready, why)
    moved = {**seen, name: Cuboid(place, seen[name].edges_m)}
    assert PickAndPlacePlanner().carry(seen, "1", place, ready).grasp.lean_rad != 0.0
    assert PickAndPlacePlanner().carry(moved, "1", LEFT, ready).grasp.lean_rad != 0.0


def test_where_one_lean_does_nothing_is_set_down(world: ArmWorld) -> None:
    assert reach_sub_goal(world, PickAndPlacePlanner(), known(world), "1", FREE).cleared == ()


@pytest.mark.parametrize("why", [why for why in RefusalReason if why is not RefusalReason.NO_PATH])
def test_no_other_refusal_leads_to_one(world: ArmWorld, why: RefusalReason) -> None:
    planner = Endless()
    seen = objects(world)
    assert plan_regrasp(planner, seen, "1", LEFT, panda.READY_RAD, RefusedError(why, "")) == ()
    assert planner.count == 0


def test_where_it_does_not_help_the_first_refusal_stands(world: ArmWorld) -> None:
    planner = Endless()
    with pytest.raises(RefusedError) as caught:
        reach_sub_goal(
            Still(world), planner, known(world), "4", FREE, ExecutionOptions(keep=("1", "2", "3"))
        )
    assert caught.value.why is RefusalReason.NO_PATH
    # To its sub-goal, and to where it would be set down.
    assert planner.count == 2


def test_what_fails_on_the_way_is_told_in_words(world: ArmWorld) -> None:
    with pytest.raises(ManipulationError) as caught:
        reach_sub_goal(
            Numb(world),
            PickAndPlacePlanner(),
            known(world),
            "1",
            LEFT,
            ExecutionOptions(keep=TOWER),
        )
    assert "1 was to be set down on the way: 1 was tried" in str(caught.value)
    assert ExecutionResult.NOT_GRASPED.value in str(caught.value) and at_home(world)


def test_what_fails_after_it_is_told_in_words(world: ArmWorld) -> None:
    body = Numb(world, since="cleared")
    with pytest.raises(
        ManipulationError, match=r"^1 was set down on the way, to be regrasped; then"
    ):
        reach_sub_goal(
            body,
            PickAndPlacePlanner(),
            known(world),
            "1",
            LEFT,
            ExecutionOptions(mark=body.mark, keep=TOWER),
        )
    assert at_home(world)
