"""Failures during execution are retried, or end at rest with a reason."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from arm_scenes import (
    BESIDE,
    HEMMED_IN,
    ON_THE_LARGE_ONE,
    PLACED_M,
    STAYED_M,
    Noting,
    Numb,
    Through,
    above,
    at_home,
    known,
    pictured,
    put,
    three,
)

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.execute import ExecutionResult, execute
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import (
    MAX_TRIES,
    ExecutionOptions,
    ManipulationError,
    reach_sub_goal,
    seen_turned_rad,
)
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render import Renderer

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


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
    carry = PickAndPlacePlanner().carry(known(world)(), "1", BESIDE, world.joints())
    marks: list[str] = []
    assert execute(Snatched(world, ELSEWHERE), carry, marks.append) is ExecutionResult.NOT_GRASPED
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
    performed = reach_sub_goal(body, planner, look, "1", ON_THE_LARGE_ONE)
    assert performed.tries == 2 and "try 2" in str(performed)
    first, second = planner.carries
    assert math.dist(second.grasp.hand.position[:2], ELSEWHERE.position[:2]) < 0.002
    assert performed.motion_s == pytest.approx(first.duration_s + second.duration_s)
    assert world.pose(1).distance_m(second.placement.cuboid.pose) < 2 * PLACED_M
    assert at_home(world)


def test_what_stands_too_near_where_it_was_snatched_to_is_moved_aside(world: ArmWorld) -> None:
    put(world, ("small", 0.5, 0.2, 0.0, 0.3), *HEMMED_IN)
    amid = Pose.upright(0.5, 0.0, 0.02)
    before = world.poses()
    marks: list[str] = []
    performed = reach_sub_goal(
        Snatched(world, amid),
        PickAndPlacePlanner(),
        known(world),
        "1",
        BESIDE,
        ExecutionOptions(mark=marks.append),
    )
    assert performed.tries == 2
    assert marks.index("not grasped") < marks.index("clearing") < marks.index("cleared")
    # Those on two opposite sides of it.
    assert {name for name, _ in performed.cleared} in ({"2", "3"}, {"4", "5"})
    after = world.poses()
    for name, place in performed.cleared:
        assert after[int(name)].distance_m(place) < PLACED_M
    for other in {2, 3, 4, 5} - {int(name) for name, _ in performed.cleared}:
        assert after[other].distance_m(before[other]) < STAYED_M
    assert after[1].distance_m(BESIDE) < PLACED_M + performed.corrected_m
    assert performed.shifted == () and performed.motion_s > 3.0 * (2 + 2)
    assert at_home(world)


def test_where_it_was_snatched_to_it_may_be_out_of_reach(world: ArmWorld) -> None:
    put(world, ("small", 0.5, 0.2, 0.0, 0.3), *HEMMED_IN)
    amid = Pose.upright(0.5, 0.0, 0.02)
    with pytest.raises(ManipulationError, match="at try 1, and now") as caught:
        reach_sub_goal(
            Snatched(world, amid),
            PickAndPlacePlanner(),
            known(world),
            "1",
            BESIDE,
            ExecutionOptions(keep="2345"),
        )
    assert str(caught.value).startswith(f"1: {ExecutionResult.NOT_GRASPED.value}")
    assert world.pose(1).distance_m(amid) < STAYED_M and at_home(world)


def test_a_grasp_that_always_fails_ends_after_a_few_tries(world: ArmWorld) -> None:
    three(world)
    before, planner = world.poses(), Noting()
    marks: list[str] = []
    with pytest.raises(ManipulationError, match="1") as caught:
        reach_sub_goal(
            Numb(world), planner, known(world), "1", BESIDE, ExecutionOptions(mark=marks.append)
        )
    assert ExecutionResult.NOT_GRASPED.value in str(caught.value) and str(MAX_TRIES) in str(
        caught.value
    )
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
    carry = PickAndPlacePlanner().carry(known(world)(), "1", BESIDE, world.joints())
    assert execute(Numb(world), carry) is ExecutionResult.NOT_GRASPED
    assert at_home(world)


class Turned(Through):
    """When the arm is home, the block has been turned where it stands; `times` times in all."""

    def __init__(self, world: ArmWorld, by_rad: float, times: int) -> None:
        super().__init__(world)
        self._by_rad, self._times = by_rad, times

    def mark(self, event: str) -> None:
        """Is told what is done."""
        if event == "home" and self._times:
            self._times -= 1
            pose = self.world.pose(1)
            self.world.place(1, Pose.upright(*pose.position, pose.yaw_rad() + self._by_rad))


def square_off_rad(one: Pose, other: Pose) -> float:
    """Between two blocks that look the same after a quarter of a turn."""
    turn_rad = one.yaw_rad() - other.yaw_rad()
    return abs((turn_rad + math.pi / 4) % (math.pi / 2) - math.pi / 4)


@pytest.mark.parametrize(("by_deg", "tries"), [(12.0, 2), (-40.0, 2), (4.0, 1), (90.0, 1)])
def test_a_block_that_is_seen_turned_is_put_again(
    world: ArmWorld, renderer: Renderer, by_deg: float, tries: int
) -> None:
    three(world)
    body, planner = Turned(world, math.radians(by_deg), 1), Noting()
    performed = reach_sub_goal(
        body, planner, pictured(world, renderer), "1", BESIDE, ExecutionOptions(mark=body.mark)
    )
    assert performed.tries == len(planner.carries) == tries
    assert square_off_rad(world.pose(1), BESIDE) < math.radians(5.0)
    assert math.dist(world.pose(1).position[:2], BESIDE.position[:2]) < 0.002 and at_home(world)


def test_a_block_that_is_always_turned_is_given_up(world: ArmWorld, renderer: Renderer) -> None:
    three(world)
    body, planner = Turned(world, math.radians(20.0), 100), Noting()
    with pytest.raises(ManipulationError, match="turned by 20°"):
        reach_sub_goal(
            body, planner, pictured(world, renderer), "1", BESIDE, ExecutionOptions(mark=body.mark)
        )
    assert len(planner.carries) == MAX_TRIES and at_home(world)


@pytest.mark.parametrize(
    ("put", "seen", "turned_deg"),
    [
        # Edges along x and y in mm, and the yaw in degrees.
        ((40, 40, 0), (40.5, 39.5, 20), 20),
        ((40, 40, 10), (40.5, 39.5, 95), 5),
        ((60, 30, 0), (59, 31, 20), 20),
        ((60, 30, 0), (59, 31, 175), 5),
        # A quarter more, its edges the other way round.
        ((60, 30, 0), (31, 59, -80), 10),
        ((60, 30, 0), (59, 31, 90), 90),
        # Too much alike to tell which of them is which.
        ((40, 36, 0), (38, 37, 90), 0),
        # Not seen whole: with edges that it is known to have, or with what is left of them.
        ((60, 30, 0), (60, 30, 20), 0),
        ((60, 30, 0), (30, 60, 20), 0),
        ((40, 40, 0), (40, 25, 20), 0),
    ],
)
def test_how_far_a_block_is_seen_to_be_turned(
    put: tuple[float, float, float], seen: tuple[float, float, float], turned_deg: float
) -> None:
    one, other = (
        Cuboid(Pose.upright(0.5, 0.0, 0.02, math.radians(yaw)), (a / 1000, b / 1000, 0.04))
        for a, b, yaw in (seen, put)
    )
    assert math.degrees(seen_turned_rad(one, other)) == pytest.approx(turned_deg, abs=1e-9)


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
    carry = PickAndPlacePlanner().carry(known(world)(), "1", ACROSS, world.joints())
    body = Jolted(world, event, after_ticks, 1)
    assert execute(body, carry, body.mark) is ExecutionResult.SLIPPED
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
    performed = reach_sub_goal(
        body, planner, pictured(world, renderer), "1", ACROSS, ExecutionOptions(mark=body.mark)
    )
    assert performed.tries == len(planner.carries) == body.marks.count("reached") == times + 1
    assert world.pose(1).distance_m(ACROSS) < 0.002
    assert at_home(world)


def test_one_that_is_always_knocked_out_is_given_up(world: ArmWorld, renderer: Renderer) -> None:
    three(world)
    body, planner = Jolted(world, "lifted", 60, 100), Noting()
    with pytest.raises(ManipulationError, match="1") as caught:
        reach_sub_goal(
            body, planner, pictured(world, renderer), "1", ACROSS, ExecutionOptions(mark=body.mark)
        )
    assert ExecutionResult.SLIPPED.value in str(caught.value) and str(MAX_TRIES) in str(
        caught.value
    )
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
        performed = reach_sub_goal(
            body, planner, pictured(world, renderer), "1", ACROSS, ExecutionOptions(mark=body.mark)
        )
    except ManipulationError as failure:
        assert ExecutionResult.SLIPPED.value in str(failure)
    else:
        assert performed.tries > 1 and performed.miss_m < 0.005
        assert world.pose(1).distance_m(ACROSS) < 0.005
    assert 1 <= len(planner.carries) == body.marks.count("reached") <= MAX_TRIES
    assert at_home(world)
