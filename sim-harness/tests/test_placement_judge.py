"""The judge of the arm's trials: successful steps and unexpected contacts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from arm_scenes import above

from nsrm_harness import domain as domains
from nsrm_harness.data.moves import Move, target
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementJudge, turned_rad
from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.robot_interface import wait
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.blocks import Block

CUBE = Block((), (0.04, 0.04, 0.04), (0.8, 0.1, 0.1))


@pytest.fixture(scope="module")
def domain() -> Domain:
    return domains.load()


@pytest.fixture
def standing() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as world:
        world.spawn(
            [CUBE, CUBE, CUBE],
            [Pose.upright(x, y, 0.02) for x, y in ((0.4, -0.2), (0.4, 0.0), (0.4, 0.2))],
        )
        world.settle()
        yield world


def descend(world: ArmWorld, x: float, y: float, z: float) -> None:
    """Moves the fingertips there by way of above it, so slowly that nothing swings."""
    for height_m in (0.15, z):
        begin, end = world.joints(), above(x, y, height_m)
        for share in np.linspace(0.0, 1.0, 1500):
            world.drive(begin + share * (end - begin), 0 * begin)
            world.tick()
        wait(world, 0.5)


def on(domain: Domain) -> Move:
    """The first block on the second."""
    action = next(action for action in domain.actions if action.direction is None)
    return Move(action, 0, 1)


def test_what_was_done_as_said_is_told_from_what_was_not(
    domain: Domain, standing: ArmWorld
) -> None:
    judge, move = PlacementJudge(standing, [CUBE] * 3), on(domain)
    standing.on_tick = judge.tick
    goal = judge.begin(move)
    assert not judge.stands([move])
    standing.place(1, goal)
    wait(standing, 0.5)
    verdict = judge.end()
    assert verdict.is_as_said and judge.stands([move]) and verdict.seconds == 0.5

    x, y, z = goal.position
    for wrong in (Pose.upright(x + 0.006, y, z), Pose.upright(x, y, z, math.radians(7))):
        judge.begin(move)
        standing.place(1, wrong)
        wait(standing, 0.5)
        assert not judge.end().is_as_said
        assert not judge.stands([move])

    judge.begin(move)
    standing.place(1, goal)
    standing.place(3, Pose.upright(0.4, 0.204, 0.02))
    wait(standing, 0.5)
    assert judge.end().shift_m == pytest.approx(0.004, abs=1e-4)
    assert not judge.end().is_as_said
    assert judge.end([standing.pose(3)]).is_as_said

    judge.begin(move)
    standing.place(3, Pose.upright(0.4, 0.2, 0.3))
    wait(standing, 0.05)
    assert not judge.end([standing.pose(3)]).at_rest


def test_the_world_may_go_on_before_the_first_step(domain: Domain, standing: ArmWorld) -> None:
    judge, move = PlacementJudge(standing, [CUBE] * 3), on(domain)
    standing.on_tick = judge.tick
    wait(standing, 0.5)
    standing.place(1, judge.begin(move))
    wait(standing, 0.3)
    verdict = judge.end()
    assert verdict.is_as_said and verdict.seconds == 0.3


@pytest.mark.parametrize(
    ("shift_m", "turn_deg", "push_m", "as_said"),
    [
        (0.0, 0.0, 0.0, True),
        (0.004, 0.0, 0.0, True),
        (0.006, 0.0, 0.0, False),
        (0.0, 4.0, 0.0, True),
        (0.0, -6.0, 0.0, False),
        (0.0, 94.0, 0.0, True),
        (0.0, 0.0, 0.002, True),
        (0.0, 0.0, 0.004, False),
    ],
)
def test_a_step_is_as_said_within_named_bounds(
    domain: Domain, shift_m: float, turn_deg: float, push_m: float, as_said: bool
) -> None:
    blocks = [CUBE] * 3
    places = [Pose.upright(0.5, y, 0.02, 0.1) for y in (-0.1, 0.1, 0.2)]
    left = Move(domain.action("MoveLeft"), 0, 1)
    with closing(ArmWorld()) as world:
        world.spawn(blocks, places)
        world.settle()
        judge = PlacementJudge(world, blocks)
        world.on_tick = judge.tick
        goal = judge.begin(left)
        assert goal == target(left, blocks, [world.pose(number) for number in (1, 2, 3)])
        x, y, z = goal.position
        world.place(1, Pose.upright(x + shift_m, y, z, math.radians(turn_deg)))
        x, y, z = world.pose(3).position
        world.place(3, Pose.upright(x, y + push_m, z, 0.1))
        wait(world, 0.3)
        verdict = judge.end()
    assert verdict.at_rest and verdict.is_as_said is as_said, verdict
    assert verdict.off_m == pytest.approx(shift_m, abs=3e-4)
    assert verdict.shift_m == pytest.approx(push_m, abs=3e-4)
    assert not replace(verdict, at_rest=False).is_as_said


def test_a_reference_that_someone_moves_is_the_reference_where_it_is_then(
    domain: Domain, standing: ArmWorld
) -> None:
    judge, move = PlacementJudge(standing, [CUBE] * 3), on(domain)
    judge.begin(move)
    standing.place(2, Pose.upright(0.45, 0.0, 0.02))
    standing.place(1, Pose.upright(0.45, 0.0, 0.06))
    assert judge.end().off_m == pytest.approx(0.05, abs=1e-4)
    assert not judge.end().is_in_place
    assert judge.end(by_current_reference=True).is_in_place
    # It was moved all the same.
    assert not judge.end(by_current_reference=True).is_as_said


def test_a_block_looks_the_same_after_a_quarter_of_a_turn() -> None:
    straight = Pose.upright(0, 0, 0)
    for degrees, turned in ((90, 0), (180, 0), (-88, 2), (50, 40)):
        pose = Pose.upright(0, 0, 0, math.radians(degrees))
        assert turned_rad(pose, straight) == pytest.approx(math.radians(turned), abs=1e-9)


def test_what_the_arm_touches_is_seen(domain: Domain, standing: ArmWorld) -> None:
    judge = PlacementJudge(standing, [CUBE] * 3)
    # Down onto a block that it is not to grasp, with closed fingers.
    standing.grip(0.0, panda.GRIP_N)
    judge.begin(on(domain))
    standing.on_tick = judge.tick
    descend(standing, 0.4, 0.2, 0.036)
    touched = judge.end().touched
    assert "block 3 and panda_leftfinger" in touched
    assert all("block 1" not in each for each in touched)


def test_what_the_block_in_the_hand_touches_on_its_way_is_seen(
    domain: Domain, standing: ArmWorld
) -> None:
    judge = PlacementJudge(standing, [CUBE] * 3)
    standing.on_tick = judge.tick
    judge.begin(on(domain))
    standing.place(1, Pose.upright(0.4, 0.2, 0.06))
    wait(standing, 0.3)
    standing.place(1, Pose.upright(0.4, 0.0, 0.06))
    wait(standing, 0.3)
    # It stood on the table and stands on the second block, but was on the third.
    assert "block 1 and block 3" in judge.end().touched
    assert all("block 2" not in each for each in judge.end().touched)


def test_the_fingers_may_touch_the_block_that_they_carry(
    domain: Domain, standing: ArmWorld
) -> None:
    judge = PlacementJudge(standing, [CUBE] * 3)
    judge.begin(on(domain))
    standing.on_tick = judge.tick
    descend(standing, 0.4, -0.2, 0.03)
    standing.grip(0.0, panda.GRIP_N)
    wait(standing, 1.0)
    fingers = {name for contact in standing.contacts(1) for name in contact}
    assert fingers >= {1, *panda.FINGERS}
    assert judge.end().touched == ()


def test_what_a_block_that_is_carried_aside_touches_is_seen(
    domain: Domain, standing: ArmWorld
) -> None:
    judge = PlacementJudge(standing, [CUBE] * 3)
    judge.begin(on(domain))
    standing.on_tick = judge.tick
    descend(standing, 0.4, 0.2, 0.03)
    standing.grip(0.0, panda.GRIP_N)
    wait(standing, 1.0)
    descend(standing, 0.4, 0.2, 0.15)
    assert judge.end([standing.pose(3)]).touched == ()
    # Down onto the second block with the third one.
    descend(standing, 0.4, 0.0, 0.068)
    aside = [standing.pose(3)]
    standing.grip(panda.MAX_OPENING_M, panda.GRIP_N)
    descend(standing, 0.4, 0.0, 0.15)
    standing.place(3, Pose.upright(0.4, 0.2, 0.02))
    wait(standing, 0.3)
    assert aside[0].position[2] > 0.05
    assert "block 2 and block 3" in judge.end([standing.pose(3)]).touched


@pytest.mark.slow
def test_what_a_block_stands_on_it_may_not_be_dragged_over(
    domain: Domain, standing: ArmWorld
) -> None:
    judge = PlacementJudge(standing, [CUBE] * 3)
    standing.on_tick = judge.tick
    for drag_m, touched in ((0.0, ()), (0.03, ("block 1 and table",))):
        judge.begin(on(domain))
        x, y, _ = standing.pose(1).position
        descend(standing, x, y, 0.03)
        standing.grip(0.0, panda.GRIP_N)
        wait(standing, 1.0)
        begin, end = standing.joints(), above(x + drag_m, y, 0.03)
        for share in np.linspace(0.0, 1.0, 1500):
            standing.drive(begin + share * (end - begin), 0 * begin)
            standing.tick()
        descend(standing, x + drag_m, y, 0.15)
        descend(standing, x + drag_m, y, 0.031)
        standing.grip(panda.MAX_OPENING_M, panda.GRIP_N)
        wait(standing, 0.5)
        descend(standing, x + drag_m, y, 0.15)
        assert standing.pose(1).position[0] == pytest.approx(x + drag_m, abs=0.003)
        assert judge.end().touched == touched
