"""Fingers that start late, move slowly, stop on the way or never move: the arm waits for them, or
reports it and stays where it is."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import closing

import numpy as np
import pytest
from arm_scenes import BESIDE, PLACED_M, STAYED_M, Through, at_home, known, put, three

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.execute import ExecutionResult, execute
from nsrm_harness.manipulation.gripper import (
    BEGIN_S,
    MOVE_S,
    THERE_M,
    GripperError,
    close_fingers,
    open_fingers,
)
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.robot_interface import StuckError, wait
from nsrm_harness.simulation.arm_world import ArmWorld

LATE_S = 0.05


class Hand:
    """Fingers and a clock, without an arm.

    * `late_s`: until they begin what they were told, infinite if they never do
    * `block_m`: what is between them, at which they stop when they close
    * `widest_m`: where they stop when they open
    """

    def __init__(
        self,
        at_m: float,
        late_s: float = 0.0,
        block_m: float = 0.0,
        widest_m: float = panda.MAX_OPENING_M,
        tick_s: float = 0.001,
        speed_m_s: float = 2 * panda.FINGER_SPEED_M_S,
    ) -> None:
        self.tick_s, self.time_s, self.told = tick_s, 0.0, [at_m]
        self._at_m, self._late_s, self._speed_m_s = at_m, late_s, speed_m_s
        self._block_m, self._widest_m, self._since_s = block_m, widest_m, 0.0

    def grip(self, opening_m: float, force_n: float) -> None:
        self.told.append(opening_m)
        self._since_s = self.time_s + self._late_s

    def opening_m(self) -> float:
        return self._at_m

    def tick(self) -> None:
        self.time_s += self.tick_s
        if self.time_s > self._since_s:
            wanted_m = min(max(self.told[-1], self._block_m), self._widest_m)
            most_m = self._speed_m_s * self.tick_s
            self._at_m += min(max(wanted_m - self._at_m, -most_m), most_m)

    def drive(self, joints: Joints, speeds: Joints) -> None:
        pytest.fail("the arm was driven")

    def joints(self) -> Joints:
        return panda.READY_RAD


@pytest.mark.parametrize("late_s", [0.0, LATE_S, 0.3, BEGIN_S - 0.05])
@pytest.mark.parametrize("block_m", [0.04, 0.0])
def test_fingers_that_begin_late_are_closed_when_they_have_closed(
    late_s: float, block_m: float
) -> None:
    hand = Hand(0.046, late_s, block_m)
    assert close_fingers(hand) == pytest.approx(block_m, abs=1e-9)
    assert hand.opening_m() == pytest.approx(block_m, abs=1e-9)
    assert hand.told[1:] == [0.0]
    # Not longer than it takes.
    assert hand.time_s < late_s + (0.046 - block_m) / 0.1 + 0.1


@pytest.mark.parametrize("late_s", [0.0, LATE_S, 0.3])
@pytest.mark.parametrize("begin_m", [0.0, 0.02, 0.064, 0.08])
def test_fingers_are_open_when_they_are_where_they_were_told_to_go(
    late_s: float, begin_m: float
) -> None:
    hand = Hand(begin_m, late_s)
    open_fingers(hand, 0.066)
    assert hand.opening_m() == pytest.approx(0.066, abs=1e-4)


def test_fingers_that_are_where_they_are_told_to_go_are_not_waited_for() -> None:
    hand = Hand(0.0464, late_s=float("inf"))
    open_fingers(hand, 0.046)
    assert hand.time_s < 0.1


def test_a_hand_whose_ticks_are_long_is_given_time() -> None:
    hand = Hand(0.046, block_m=0.02, tick_s=0.05)
    assert close_fingers(hand) == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("hand", "do", "words"),
    [
        (
            Hand(0.046, late_s=float("inf")),
            close_fingers,
            ["to 0.0 mm", "did not move", "are 46.0 mm open"],
        ),
        (
            Hand(0.04, late_s=float("inf")),
            lambda hand: open_fingers(hand, 0.046),
            ["to 46.0 mm", "did not move", "are 40.0 mm open"],
        ),
        (
            Hand(0.04, widest_m=0.043),
            lambda hand: open_fingers(hand, 0.046),
            ["to 46.0 mm", "stopped on the way", "are 43.0 mm open"],
        ),
        (
            Hand(0.08, speed_m_s=0.01),
            close_fingers,
            ["to 0.0 mm", "still moved after", "look at its hand"],
        ),
    ],
    ids=["never closes", "never opens", "opens halfway", "too slow"],
)
def test_fingers_that_do_not_do_as_told_are_told_to_stay_and_it_is_said(
    hand: Hand, do: Callable[[Hand], object], words: list[str]
) -> None:
    with pytest.raises(GripperError) as caught:
        do(hand)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert hand.told[-1] == pytest.approx(hand.opening_m(), abs=1e-9)
    assert hand.time_s < BEGIN_S + MOVE_S + 0.1


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


class Late(Through):
    """Its hand does what it is told, and tells how far it is open, so much later; keeps how far the
    fingers were from where they were told to open to when the arm moved."""

    def __init__(self, world: ArmWorld, late_s: float) -> None:
        super().__init__(world)
        self._ticks = round(late_s / world.tick_s)
        self._told: deque[tuple[int, float, float]] = deque()
        self._openings = deque([world.opening_m()] * (self._ticks + 1), self._ticks + 1)
        self._tick = 0
        self._opening_m = 0.0
        self.off_m = 0.0

    def grip(self, opening_m: float, force_n: float) -> None:
        self._told.append((self._tick + self._ticks, opening_m, force_n))
        self._opening_m = opening_m

    def opening_m(self) -> float:
        return self._openings[0]

    def drive(self, joints: Joints, speeds: Joints) -> None:
        super().drive(joints, speeds)
        if self._opening_m > 0.0 and np.abs(speeds).max() > 0.0:
            self.off_m = max(self.off_m, abs(self._opening_m - self.world.opening_m()))

    def tick(self) -> None:
        while self._told and self._told[0][0] <= self._tick:
            _, opening_m, force_n = self._told.popleft()
            super().grip(opening_m, force_n)
        super().tick()
        self._tick += 1
        self._openings.append(self.world.opening_m())


@pytest.mark.parametrize("late_s", [0.0, LATE_S, 0.2])
def test_with_fingers_that_are_late_a_block_is_carried_as_well(
    world: ArmWorld, late_s: float
) -> None:
    three(world)
    carry = PickAndPlacePlanner().carry(known(world)(), "1", BESIDE, world.joints())
    body = Late(world, late_s)
    assert execute(body, carry) is ExecutionResult.PLACED
    assert body.off_m < THERE_M
    assert world.pose(1).distance_m(BESIDE) < PLACED_M and at_home(world)


def test_the_arm_moves_when_fingers_that_closed_on_nothing_are_open_again(world: ArmWorld) -> None:
    put(world, ("lego", 0.45, -0.1, 0, 0.3))
    carry = PickAndPlacePlanner().carry(
        known(world)(), "1", Pose.upright(0.5, 0.1, 0.025), world.joints()
    )
    world.place(1, Pose.upright(0.6, 0.2, 0.025))
    body = Late(world, 0.0)
    assert execute(body, carry) is ExecutionResult.NOT_GRASPED
    # From shut to as wide as a large block they take 0.7 s.
    assert body.off_m < THERE_M


class Dead(Through):
    """Its fingers don't move any more from the so-manieth time on that they are told to."""

    def __init__(self, world: ArmWorld, since: int) -> None:
        super().__init__(world)
        self._left = since - 1
        self.told: list[float] = []
        self.driven: list[Joints] = []

    def grip(self, opening_m: float, force_n: float) -> None:
        self.told.append(opening_m)
        if self._left > 0:
            self._left -= 1
            super().grip(opening_m, force_n)

    def drive(self, joints: Joints, speeds: Joints) -> None:
        self.driven.append(speeds)
        super().drive(joints, speeds)


@pytest.mark.parametrize(
    ("since", "marks"),
    [(1, []), (2, ["reached"]), (3, ["reached", "grasped", "lifted", "above"])],
    ids=["open at first", "close", "let go"],
)
def test_a_hand_that_is_dead_is_noticed_and_the_arm_stays(
    world: ArmWorld, since: int, marks: list[str]
) -> None:
    three(world)
    carry = PickAndPlacePlanner().carry(known(world)(), "1", BESIDE, world.joints())
    body = Dead(world, since)
    done: list[str] = []
    # Those who know of joints alone take it for what it is, too.
    with pytest.raises(StuckError, match="look at its hand") as caught:
        execute(body, carry, done.append)
    assert isinstance(caught.value, GripperError)
    assert done == marks
    assert np.abs(body.driven[-1]).max() < 1e-12
    assert body.told[-1] == pytest.approx(world.opening_m(), abs=1e-6)
    joints, pose, opening_m = world.joints(), world.pose(1), world.opening_m()
    wait(world, 1.0)
    np.testing.assert_allclose(world.joints(), joints, atol=1e-4)
    assert world.pose(1).distance_m(pose) < STAYED_M
    assert world.opening_m() == pytest.approx(opening_m, abs=1e-4)
