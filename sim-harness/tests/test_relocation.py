"""Obstacles are moved aside, after everything is planned."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import closing
from typing import Any

import pytest
from another_process import elsewhere
from arm_scenes import (
    HEMMED_IN,
    PLACED_M,
    STAYED_M,
    Numb,
    Still,
    at_home,
    known,
    put,
)

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlace, PickAndPlacePlanner
from nsrm_harness.manipulation.relocation import (
    FINGER_ROOM_M,
    HIGHEST_M,
    LOWEST_M,
    MAX_PLACES,
    MAX_PLANS,
    STEP_M,
    Relocation,
    plan_relocations,
)
from nsrm_harness.manipulation.retries import (
    MAX_TRIES,
    ExecutionOptions,
    ManipulationError,
    reach_sub_goal,
)
from nsrm_harness.manipulation.stability import ROOM_M, gap_m
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.layout import PLACEMENT_SPACE

EDGE_M = 0.04
CUBE: Vector3 = (EDGE_M, EDGE_M, EDGE_M)
LARGE: Vector3 = (0.06, 0.06, 0.05)
FREE_RAD = math.radians(3)

pytestmark = pytest.mark.slow


def cube(x: float, y: float, foot: float = 0.0, yaw: float = 0.0, edges: Vector3 = CUBE) -> Cuboid:
    return Cuboid(Pose.upright(x, y, foot + edges[2] / 2, yaw), edges)


NO_ROOM = {"block": cube(0.45, -0.1), "near": cube(0.6, 0.0), "far": cube(0.4, 0.2)}
"""For `BESIDE_NEAR`: 2 mm from another."""
BESIDE_NEAR = Pose.upright(0.6, 0.042, 0.02)

BETWEEN = Pose.upright(0.591, 0.117, 0.02)
NO_PATH = {
    "block": cube(0.594, -0.034),
    "reference": cube(0.59, 0.186, yaw=-0.17, edges=LARGE),
    "near": cube(0.534, 0.11),
}
"""For `BETWEEN`: no room for the fingers beside two others."""

FULL = {
    "block": cube(0.5, 0.34),
    **{
        f"{row} {column}": cube(0.37 + 0.065 * row, -0.24 + 0.068 * column)
        for row in range(5)
        for column in range(8)
    },
}
"""No room for the fingers anywhere."""


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


def refusal(objects: Mapping[str, Cuboid], goal: Pose) -> RefusedError:
    with pytest.raises(RefusedError) as caught:
        PickAndPlacePlanner().carry(objects, "block", goal, panda.READY_RAD)
    return caught.value


def cleared(
    objects: Mapping[str, Cuboid],
    goal: Pose,
    keep: Collection[str] = (),
    planner: PickAndPlacePlanner | None = None,
) -> tuple[Relocation, ...]:
    """What is moved aside for the block."""
    why = refusal(objects, goal)
    return plan_relocations(
        planner or PickAndPlacePlanner(), objects, "block", goal, panda.READY_RAD, why, keep
    )


class Asked(PickAndPlacePlanner):
    """Keeps what it was asked for, and what it planned."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[tuple[Mapping[str, Cuboid], str, Pose, PickAndPlace | None]] = []

    def carry(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints, **how: bool
    ) -> PickAndPlace:
        self.asked.append((objects, name, goal, None))
        planned = super().carry(objects, name, goal, begin, **how)
        self.asked[-1] = (objects, name, goal, planned)
        return planned


def no_room(world: ArmWorld) -> tuple[Pose, set[str], set[str]]:
    put(world, ("small", 0.45, -0.1, 0, 0.3), ("small", 0.6, 0, 0, 0.1), ("lego", 0.4, 0.2, 0, 0))
    return BESIDE_NEAR, {"2", "3"}, {"2"}


def no_way(world: ArmWorld) -> tuple[Pose, set[str], set[str]]:
    put(
        world,
        ("small", 0.594, -0.034, 0, -0.13),
        ("lego", 0.59, 0.186, 0, -0.17),
        ("small", 0.534, 0.11, 0, 0),
    )
    return BETWEEN, {"3"}, {"3"}


def hemmed_in(world: ArmWorld) -> tuple[Pose, set[str], set[str]]:
    put(world, ("small", 0.5, 0.0, 0, 0.0), *HEMMED_IN)
    # Those before and behind it.
    return Pose.upright(0.5, -0.2, 0.02), {"2", "3"}, {"2", "3"}


@pytest.mark.parametrize("scene", [no_room, no_way, hemmed_in])
def test_what_stands_too_near_is_moved_aside_first(world: ArmWorld, scene: Any) -> None:
    goal, movable, moved = scene(world)
    before = world.poses()
    keep = {str(number) for number in before} - movable
    marks: list[str] = []
    performed = reach_sub_goal(
        world,
        PickAndPlacePlanner(),
        known(world),
        "1",
        goal,
        ExecutionOptions(mark=marks.append, keep=keep),
    )
    after = world.poses()
    assert {name for name, _ in performed.cleared} == moved
    for name, place in performed.cleared:
        assert after[int(name)].distance_m(place) < PLACED_M
        assert place.angle_rad(before[int(name)]) < 0.001
        assert after[int(name)].angle_rad(place) < FREE_RAD
    assert after[1].distance_m(goal) < PLACED_M + performed.corrected_m
    assert performed.name == "1" and performed.tries == 1 and performed.shifted == ()
    for number in set(before) - {1, *map(int, moved)}:
        assert after[number].distance_m(before[number]) < STAYED_M
    assert at_home(world) and world.settle().at_rest
    # It is said: first that it is to be done, in the end what was done.
    assert marks[0] == "clearing" and marks.count("cleared") == 1
    assert marks[: marks.index("cleared")].count("home") == len(moved)
    verb = "was" if len(moved) == 1 else "were"
    first = " and ".join(name for name, _ in performed.cleared)
    assert f"; {first} {verb} moved aside first" in str(performed)
    assert {name: place["position"] for name, place in performed.as_json()["cleared"].items()} == {
        name: place.position for name, place in performed.cleared
    }
    # Of all that was carried.
    assert performed.motion_s > 3.0 * (len(moved) + 1)


def test_where_nothing_is_too_near_nothing_is_moved_aside(world: ArmWorld) -> None:
    put(world, ("small", 0.45, -0.1, 0, 0.3), ("small", 0.6, 0.0, 0, 0.0))
    planner = Asked()
    marks: list[str] = []
    performed = reach_sub_goal(
        world,
        planner,
        known(world),
        "1",
        Pose.upright(0.5, 0.2, 0.02),
        ExecutionOptions(mark=marks.append),
    )
    assert performed.cleared == () and "aside" not in str(performed)
    assert performed.as_json()["cleared"] == {}
    assert len(planner.asked) == 1 and marks[0] == "reached"


def test_those_in_the_way_are_named_and_nothing_else() -> None:
    assert set(refusal(NO_PATH, BETWEEN).in_the_way) == {"reference", "near"}
    # The one that needs to go less far comes first; the message names the nearest.
    objects = {"nearer": cube(0.6, 0.083), **NO_ROOM}
    why = refusal(objects, BESIDE_NEAR)
    assert why.why is RefusalReason.NO_ROOM and why.in_the_way == ("near", "nearer")
    assert "1 mm from nearer" in str(why)


def test_what_is_to_be_kept_is_kept() -> None:
    assert [name for name, _ in cleared(NO_PATH, BETWEEN, ["reference"])] == ["near"]
    assert [name for name, _ in cleared(NO_PATH, BETWEEN, ["near"])] == ["reference"]
    assert cleared(NO_PATH, BETWEEN, ["near", "reference"]) == ()


def test_without_a_clearing_the_first_refusal_stands(world: ArmWorld) -> None:
    goal, _, _ = no_way(world)
    with pytest.raises(RefusedError) as expected:
        PickAndPlacePlanner().carry(known(world)(), "1", goal, world.joints())
    with pytest.raises(RefusedError) as caught:
        reach_sub_goal(
            Still(world),
            PickAndPlacePlanner(),
            known(world),
            "1",
            goal,
            ExecutionOptions(keep=("2", "3")),
        )
    assert caught.value.why is RefusalReason.NO_PATH
    assert str(caught.value) == str(expected.value)


@pytest.mark.parametrize(
    ("objects", "name", "goal", "why"),
    [
        (NO_ROOM, "unknown", BESIDE_NEAR, RefusalReason.UNSEEN),
        (
            {**NO_ROOM, "on it": cube(0.45, -0.1, EDGE_M)},
            "block",
            BESIDE_NEAR,
            RefusalReason.COVERED,
        ),
        (NO_ROOM, "block", Pose.upright(0.6, 0.15, 0.06), RefusalReason.NO_SUPPORT),
        (NO_ROOM, "block", Pose.upright(0.6, 0.025, 0.06), RefusalReason.UNSTABLE),
        (NO_ROOM, "block", Pose.upright(0.93, 0.0, 0.02), RefusalReason.OUT_OF_REACH),
    ],
)
def test_no_other_refusal_leads_to_a_clearing(
    world: ArmWorld, objects: Mapping[str, Cuboid], name: str, goal: Pose, why: RefusalReason
) -> None:
    planner = Asked()
    with pytest.raises(RefusedError) as caught:
        reach_sub_goal(Still(world), planner, lambda: objects, name, goal)
    assert caught.value.why is why
    assert caught.value.in_the_way == (("on it",) if why is RefusalReason.COVERED else ())
    assert len(planner.asked) == 1
    # Whatever is said to stand there.
    other = RefusedError(why, "", ("near",))
    relocations = plan_relocations(planner, objects, "block", goal, panda.READY_RAD, other)
    assert relocations == () and len(planner.asked) == 1


def test_where_there_is_no_free_place_nothing_is_moved(world: ArmWorld) -> None:
    goal = Pose.upright(0.5, 0.03, 0.02)
    # Without the one it would do.
    (within,) = refusal(FULL, goal).in_the_way
    rest = {name: cuboid for name, cuboid in FULL.items() if name != within}
    PickAndPlacePlanner().carry(rest, "block", goal, panda.READY_RAD)
    with pytest.raises(RefusedError) as caught:
        reach_sub_goal(Still(world), PickAndPlacePlanner(), lambda: FULL, "block", goal)
    assert caught.value.why is RefusalReason.NO_ROOM


def test_what_carries_another_is_left_alone(world: ArmWorld) -> None:
    block = cube(0.45, -0.1, edges=LARGE)
    goal = Pose.upright(0.6, 0.052, 0.025)
    stack = {"block": block, "lower": cube(0.6, 0.0), "upper": cube(0.6, 0.0, EDGE_M)}
    assert refusal(stack, goal).in_the_way == ("lower", "upper")
    with pytest.raises(RefusedError) as caught:
        reach_sub_goal(Still(world), PickAndPlacePlanner(), lambda: stack, "block", goal)
    assert caught.value.why is RefusalReason.NO_ROOM
    # Side by side, both are moved.
    apart = {**stack, "upper": cube(0.6, 0.104)}
    assert {name for name, _ in cleared(apart, goal)} == {"lower", "upper"}


def test_what_it_is_put_on_stays() -> None:
    """The block could be grasped if one of the two were gone that it is to stand on."""
    lower = {"first": cube(0.5, 0.0), "second": cube(0.5, 0.042)}
    beside = {"left": cube(0.452, 0.09), "right": cube(0.548, 0.09)}
    objects = {"block": cube(0.5, 0.09), **lower, **beside}
    goal = Pose.upright(0.5, 0.0035, 0.06)
    why = refusal(objects, goal)
    assert "second" in why.in_the_way
    rest = {name: cuboid for name, cuboid in objects.items() if name != "second"}
    PickAndPlacePlanner().carry(rest, "block", goal, panda.READY_RAD)
    assert cleared(objects, goal, beside) == ()


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.0])
def test_it_is_put_upright_and_turned_as_it_was_on_the_nearest_free_place(yaw: float) -> None:
    objects = {**NO_ROOM, "near": cube(0.6, 0.0, yaw=yaw, edges=(EDGE_M, EDGE_M, 0.03))}
    ((name, place),) = cleared(objects, BESIDE_NEAR)
    near = objects["near"]
    assert name == "near"
    assert place.yaw_rad() == pytest.approx(yaw) and place.position[2] == pytest.approx(0.015)
    x, y, _ = place.position
    assert x / STEP_M == pytest.approx(round(x / STEP_M))
    assert y / STEP_M == pytest.approx(round(y / STEP_M))
    others = [objects["block"], objects["far"], Cuboid(BESIDE_NEAR, CUBE)]
    assert all(gap_m(Cuboid(place, near.edges_m), other) >= FINGER_ROOM_M for other in others)
    # One step nearer, straight away from the sub-goal, there would be too little room.
    back = Pose.upright(0.6, y + STEP_M, 0.015, yaw)
    assert (x, y) == (0.6, pytest.approx(place.position[1])) and y < 0
    assert gap_m(Cuboid(back, near.edges_m), others[-1]) < FINGER_ROOM_M


def test_a_blocker_is_put_where_the_blocks_stand_at_the_start() -> None:
    assert PLACEMENT_SPACE.min[:2] == pytest.approx(LOWEST_M)
    assert PLACEMENT_SPACE.max[:2] == pytest.approx(HIGHEST_M)
    # At its border, where the nearest place would lie beyond it.
    objects = {"block": cube(0.45, -0.1), "near": cube(0.6, 0.23)}
    goal = Pose.upright(0.6, 0.188, 0.02)
    ((_, place),) = cleared(objects, goal)
    assert PLACEMENT_SPACE.contains(place.position)
    assert FINGER_ROOM_M > ROOM_M and place.position[1] < 0.24 + 1e-9


def test_the_same_is_moved_to_the_same_place_in_another_process() -> None:
    found = cleared(NO_PATH, BETWEEN)
    there = elsewhere("import test_relocation as t; print(t.cleared(t.NO_PATH, t.BETWEEN))")
    assert found and there == repr(found)


class MovedError(Exception):
    """Something has begun to move."""


class Begins(Still):
    """Ends where it would be moved first."""

    def drive(self, joints: Joints, speeds: Joints) -> None:
        raise MovedError

    def grip(self, opening_m: float, force_n: float) -> None:
        raise MovedError


def test_all_is_planned_before_the_first_motion(world: ArmWorld) -> None:
    planner = Asked()
    with pytest.raises(MovedError):
        reach_sub_goal(Begins(world), planner, lambda: NO_ROOM, "block", BESIDE_NEAR)
    ((_, place),) = cleared(NO_ROOM, BESIDE_NEAR)
    planned = [part for part in planner.asked if part[3] is not None]
    with_it_aside = {**NO_ROOM, "near": Cuboid(place, CUBE)}
    assert any(
        (objects, name, goal) == (with_it_aside, "block", BESIDE_NEAR)
        for objects, name, goal, _ in planned
    )
    assert any(
        (objects, name, goal) == (NO_ROOM, "near", place) for objects, name, goal, _ in planned
    )


class Doubting(Asked):
    """Finds no way for the block, wherever what is in its way is put, but without it."""

    def carry(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints, **how: bool
    ) -> PickAndPlace:
        planned = super().carry(objects, name, goal, begin, **how)
        if name == "block" and "near" in objects:
            raise RefusedError(RefusalReason.NO_PATH, "not proven", ("near",))
        return planned


def test_nothing_moves_for_what_is_not_proven(world: ArmWorld) -> None:
    objects = {**NO_ROOM, "near": cube(0.55, 0.1)}
    planner = Doubting()
    with pytest.raises(RefusedError, match="not proven"):
        reach_sub_goal(
            Still(world), planner, lambda: objects, "block", Pose.upright(0.45, -0.2, 0.02)
        )
    # Once as it is, once without the other, with it in each place, and to where it would be set
    # down itself.
    assert len(planner.asked) == 2 + MAX_PLACES + 1


class Choosy(PickAndPlacePlanner):
    """Does not carry the other to so many of the places that it is asked about."""

    def __init__(self, count: int) -> None:
        super().__init__()
        self._left = count

    def carry(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints, **how: bool
    ) -> PickAndPlace:
        if name == "near" and self._left:
            self._left -= 1
            raise RefusedError(RefusalReason.OUT_OF_REACH, "not there")
        return super().carry(objects, name, goal, begin, **how)


def test_where_a_blocker_can_not_be_carried_to_it_is_not_put() -> None:
    ((_, first),) = cleared(NO_ROOM, BESIDE_NEAR)
    ((_, second),) = cleared(NO_ROOM, BESIDE_NEAR, planner=Choosy(1))
    near = NO_ROOM["near"].pose
    assert first.distance_m(near) <= second.distance_m(near) < first.distance_m(near) + STEP_M
    assert second != first
    assert cleared(NO_ROOM, BESIDE_NEAR, planner=Choosy(MAX_PLACES)) == ()


class Endless(PickAndPlacePlanner):
    """Always has something else in its way, and counts."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def carry(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints, **how: bool
    ) -> PickAndPlace:
        self.count += 1
        raise RefusedError(
            RefusalReason.NO_PATH, "", tuple(other for other in objects if other != name)
        )


def test_planning_ends() -> None:
    planner = Endless()
    why = RefusedError(RefusalReason.NO_PATH, "", tuple(FULL))
    relocations = plan_relocations(planner, FULL, "block", BESIDE_NEAR, panda.READY_RAD, why)
    assert relocations == () and planner.count == MAX_PLANS


def test_a_blocker_that_can_not_be_moved_is_given_up_in_words(world: ArmWorld) -> None:
    goal, _, _ = no_room(world)
    before = world.poses()
    with pytest.raises(ManipulationError) as caught:
        reach_sub_goal(Numb(world), PickAndPlacePlanner(), known(world), "1", goal)
    words = str(caught.value)
    assert "2 stands in the way of 1 and was to be moved aside first" in words
    assert ExecutionResult.NOT_GRASPED.value in words and f"{MAX_TRIES} times" in words
    after = world.poses()
    assert all(after[number].distance_m(before[number]) < STAYED_M for number in before)
    assert at_home(world)


def test_one_that_slips_is_moved_aside_at_another_try(world: ArmWorld) -> None:
    goal, _, _ = no_room(world)
    body = Numb(world, until="not grasped")
    performed = reach_sub_goal(
        body, PickAndPlacePlanner(), known(world), "1", goal, ExecutionOptions(mark=body.mark)
    )
    ((name, place),) = performed.cleared
    assert world.pose(int(name)).distance_m(place) < PLACED_M
    assert world.pose(1).distance_m(goal) < PLACED_M
    # Its own.
    assert performed.tries == 1


def test_where_the_block_fails_it_is_said_what_was_moved_for_it(world: ArmWorld) -> None:
    goal, _, _ = no_room(world)
    before = world.pose(2)
    body = Numb(world, since="cleared")
    with pytest.raises(ManipulationError, match=r"^2 was moved aside first; then: 1 was tried"):
        reach_sub_goal(
            body, PickAndPlacePlanner(), known(world), "1", goal, ExecutionOptions(mark=body.mark)
        )
    assert world.pose(2).distance_m(before) > 0.02 and at_home(world)


def test_what_is_pushed_meanwhile_is_said(world: ArmWorld) -> None:
    goal, _, _ = no_room(world)
    x, y, z = world.pose(3).position
    pushes = iter([Pose.upright(x, y + 0.006, z)])

    def mark(event: str) -> None:
        if event == "above" and (pose := next(pushes, None)):
            world.place(3, pose)

    performed = reach_sub_goal(
        world, PickAndPlacePlanner(), known(world), "1", goal, ExecutionOptions(mark=mark)
    )
    ((name, shift_m),) = performed.shifted
    assert performed.cleared and name == "3" and shift_m == pytest.approx(0.006, abs=0.001)
