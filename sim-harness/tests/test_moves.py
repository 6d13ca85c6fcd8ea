"""Moves: where blocks go, and which moves are not allowed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data.moves import GAP_M, Arrangement, Move, stacking_action, target
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block, block_from_attributes

DOMAIN = domains.load()
ON, RIGHT, LEFT = (DOMAIN.action(name) for name in ("MoveOn", "MoveRight", "MoveLeft"))
LEGO, SMALL, OTHER = 0, 1, 2


def block(color: str, size: str) -> Block:
    return block_from_attributes(DOMAIN, {"color": color, "size": size})


BLOCKS = (block("red", "lego"), block("blue", "small"), block("green", "small"))


def arrangement(*xy: tuple[float, float]) -> Arrangement:
    poses = [
        Pose.upright(x, y, each.edges_m[2] / 2, 0.1)
        for (x, y), each in zip(xy, BLOCKS, strict=True)
    ]
    return Arrangement.on_table(BLOCKS, poses)


@pytest.fixture
def apart() -> Arrangement:
    return arrangement((0.5, 0.0), (0.45, 0.2), (0.4, -0.2))


def test_on_is_centred_over_the_reference_and_square(apart: Arrangement) -> None:
    goal = target(Move(ON, SMALL, LEGO), apart.blocks, apart.poses)
    assert goal.position == pytest.approx((0.5, 0.0, 0.05 + 0.02))
    assert goal.orientation == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(("action", "side"), [(RIGHT, 1.0), (LEFT, -1.0)])
def test_beside_leaves_the_gap_in_the_actions_direction(
    apart: Arrangement, action: domains.Action, side: float
) -> None:
    goal = target(Move(action, SMALL, LEGO), apart.blocks, apart.poses)
    assert goal.position == pytest.approx((0.5, side * (0.03 + 0.02 + GAP_M), 0.02))


def test_moves_of_blocks_that_bear_others_and_onto_them_are_not_commanded(
    apart: Arrangement,
) -> None:
    stacked = apart.after(Move(ON, SMALL, LEGO))
    assert stacked.base == (None, LEGO, None)
    assert not stacked.allowed(Move(RIGHT, LEGO, OTHER)), "it bears the small one"
    assert not stacked.allowed(Move(ON, OTHER, LEGO)), "there is one on it"
    assert not stacked.allowed(Move(RIGHT, OTHER, SMALL)), "it does not stand on the table"
    assert stacked.allowed(Move(ON, OTHER, SMALL))
    assert stacked.allowed(Move(RIGHT, OTHER, LEGO))
    down = stacked.after(Move(LEFT, SMALL, LEGO))
    assert down.base == (None, None, None)
    assert down.allowed(Move(RIGHT, LEGO, OTHER))


def test_the_stacking_action_puts_a_block_on_another() -> None:
    assert stacking_action(DOMAIN) == ON
    beside = replace(DOMAIN, actions=(RIGHT, LEFT))
    with pytest.raises(EpisodeSettingsError, match="has no action that puts a block on another"):
        stacking_action(beside)


def test_a_block_and_itself_are_not_commanded(apart: Arrangement) -> None:
    assert not any(apart.allowed(Move(action, LEGO, LEGO)) for action in DOMAIN.actions)


def test_a_place_that_is_taken_or_outside_is_not_commanded() -> None:
    crowded = arrangement((0.5, 0.0), (0.45, 0.2), (0.5, 0.1))
    assert not crowded.allowed(Move(RIGHT, SMALL, LEGO)), "the other one stands there"
    assert crowded.allowed(Move(LEFT, SMALL, LEGO))
    border = arrangement((0.5, 0.2), (0.45, 0.0), (0.4, -0.2))
    assert not border.allowed(Move(RIGHT, SMALL, LEGO)), "outside the work space"


def test_a_neighbour_hinders_only_at_its_own_height() -> None:
    # A lego block on a small one would reach over the neighbour 12 mm beside.
    close = arrangement((0.6, -0.2), (0.5, 0.0), (0.5, 0.052))
    assert not close.allowed(Move(ON, LEGO, SMALL))
    # On two small ones it passes above it.
    tower = Arrangement.on_table(
        (*BLOCKS, block("cyan", "small")), (*close.poses, Pose.upright(0.4, 0.0, 0.02))
    ).after(Move(ON, 3, SMALL))
    assert tower.allowed(Move(ON, LEGO, 3))


def test_all_moves_are_the_allowed_ones(apart: Arrangement) -> None:
    moves = apart.moves(DOMAIN)
    assert all(apart.allowed(move) for move in moves)
    assert len(set(moves)) == len(moves) > 6
