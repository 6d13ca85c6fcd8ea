"""Computes where a block goes when it is put on or beside another one, and which moves are allowed.

This is geometry on known poses, without physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.domain import Action, Domain
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.layout import PLACEMENT_SPACE, Space, apart, footprint

#: Gap between the faces of a block and of its reference, metres.
GAP_M = 0.025
#: Smallest distance of a block at its target from all blocks but its reference, metres.
CLEARANCE_M = 0.010


@dataclass(frozen=True)
class Move:
    """An action on two blocks of an arrangement, by their indices."""

    action: Action
    moved: int
    reference: int


def stacking_action(domain: Domain) -> Action:
    """The domain's first action that puts a block on another one. Raises
    ``EpisodeSettingsError`` if it has none."""
    for action in domain.actions:
        if action.direction is None:
            return action
    raise EpisodeSettingsError(
        f"the domain {domain.name!r} has no action that puts a block on another one: add one, or "
        f"make no stacks"
    )


def target(move: Move, blocks: Sequence[Block], poses: Sequence[Pose]) -> Pose:
    """The target pose of the moved block's centre, square to the table.

    On: centred above the reference. Beside: on the table, `GAP_M` from the reference in the
    action's direction, aligned with it in the other.
    """
    moved, reference = blocks[move.moved], blocks[move.reference]
    x, y, z = poses[move.reference].position
    if move.action.direction is None:
        return Pose.upright(x, y, z + reference.edges_m[2] / 2 + moved.edges_m[2] / 2)
    dx, dy = move.action.direction
    along_x = GAP_M + (moved.edges_m[0] + reference.edges_m[0]) / 2
    along_y = GAP_M + (moved.edges_m[1] + reference.edges_m[1]) / 2
    return Pose.upright(x + dx * along_x, y + dy * along_y, moved.edges_m[2] / 2)


@dataclass(frozen=True)
class Arrangement:
    """Blocks, their poses, and which rests on which."""

    blocks: tuple[Block, ...]
    poses: tuple[Pose, ...]
    #: Index of the block that each rests on; None for the table.
    base: tuple[int | None, ...]

    @staticmethod
    def on_table(blocks: Sequence[Block], poses: Sequence[Pose]) -> Arrangement:
        """An arrangement with all blocks on the table."""
        return Arrangement(tuple(blocks), tuple(poses), (None,) * len(blocks))

    def allowed(self, move: Move, space: Space = PLACEMENT_SPACE) -> bool:
        """Whether the move is allowed: the moved block supports none; the reference supports none
        (on) or stands on the table (beside); the target lies in `space` and is clear of all other
        blocks."""
        if move.moved == move.reference or move.moved in self.base:
            return False
        on = move.action.direction is None
        if on and move.reference in self.base:
            return False
        if not on and self.base[move.reference] is not None:
            return False
        goal = target(move, self.blocks, self.poses)
        return self.has_room(move.moved, move.reference, goal, space)

    def has_room(
        self, moved: int, reference: int, goal: Pose, space: Space = PLACEMENT_SPACE
    ) -> bool:
        """Whether a target lies in `space` and is clear of all other blocks."""
        return space.contains(goal.position) and all(
            self._clear(self.blocks[moved], goal, other)
            for other in range(len(self.blocks))
            if other not in (moved, reference)
        )

    def after(self, move: Move) -> Arrangement:
        """The arrangement after the move, if the block ends at its target."""
        poses, base = list(self.poses), list(self.base)
        poses[move.moved] = target(move, self.blocks, self.poses)
        base[move.moved] = move.reference if move.action.direction is None else None
        return Arrangement(self.blocks, tuple(poses), tuple(base))

    def moves(self, domain: Domain, among: Sequence[int] | None = None) -> list[Move]:
        """All allowed moves, in a fixed order.

        `among`: indices of the blocks that may be moved or be references; None for all.
        """
        indices = range(len(self.blocks)) if among is None else among
        every = (
            Move(action, moved, reference)
            for action in domain.actions
            for moved in indices
            for reference in indices
        )
        return [move for move in every if self.allowed(move)]

    def _clear(self, block: Block, pose: Pose, other: int) -> bool:
        standing = self.poses[other]
        between_m = abs(pose.position[2] - standing.position[2])
        if between_m >= (block.edges_m[2] + self.blocks[other].edges_m[2]) / 2 + CLEARANCE_M:
            return True
        # At this distance, a strip along one of the edges separates any two blocks;
        # this saves most of
        # the exact tests.
        reach_m = _half_diagonal_m(block) + _half_diagonal_m(self.blocks[other]) + CLEARANCE_M
        if math.dist(pose.position[:2], standing.position[:2]) >= math.sqrt(2.0) * reach_m:
            return True
        return apart(footprint(block, pose), footprint(self.blocks[other], standing), CLEARANCE_M)


def _half_diagonal_m(block: Block) -> float:
    return math.hypot(block.edges_m[0], block.edges_m[1]) / 2
