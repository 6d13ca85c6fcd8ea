"""The sentences of the figures, and random scenes in which they are possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.moves import Arrangement, Move
from nsrm_harness.data.programs import sample_blocks
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.layout import LayoutError, sample_layout

BLOCKS = (4, 6)
"""Smallest and largest number in a scene, as in training."""
MAX_TRIES = 20_000


@dataclass(frozen=True)
class Figure:
    """A figure of the paper's annexure I.

    * `sentence`: word for word
    * `program`: its meaning, which only the judge knows
    """

    number: int
    sentence: str
    program: Program


FIGURES = (
    Figure(
        2,
        "put cyan block on the blue block",
        (Step("MoveOn", ("cyan",), ("blue",)),),
    ),
    Figure(
        3,
        "put yellow block to the left of white block and put magenta small block on yellow block",
        (
            Step("MoveLeft", ("yellow",), ("white",)),
            Step("MoveOn", ("magenta", "small"), ("yellow",)),
        ),
    ),
    Figure(
        4,
        "put red block on blue block and put magenta block on red block",
        (
            Step("MoveOn", ("red",), ("blue",)),
            Step("MoveOn", ("magenta",), ("red",)),
        ),
    ),
    Figure(
        5,
        "put red block to the left of yellow block and put cyan block to the left of red block "
        "and then put red block on cyan block",
        (
            Step("MoveLeft", ("red",), ("yellow",)),
            Step("MoveLeft", ("cyan",), ("red",)),
            Step("MoveOn", ("red",), ("cyan",)),
        ),
    ),
)


@dataclass(frozen=True)
class FigureScene:
    """Blocks on the table, and the moves that a figure's sentence commands there."""

    arrangement: Arrangement
    moves: tuple[Move, ...]


def draw(figure: Figure, domain: Domain, seed: int, variation: int) -> FigureScene:
    """Draws random blocks in which each description is unique, with room for every step."""
    rng = generator(seed, "figures", 10 * variation + figure.number)
    for _ in range(MAX_TRIES):
        blocks = sample_blocks(rng, domain, int(rng.integers(BLOCKS[0], BLOCKS[1] + 1)))
        moves = _meant(figure.program, domain, blocks)
        if moves is None:
            continue
        try:
            arrangement = Arrangement.on_table(blocks, sample_layout(rng, blocks))
        except LayoutError:
            continue
        if _has_room(arrangement, moves):
            return FigureScene(arrangement, moves)
    raise HarnessError(
        f"figure {figure.number}, variation {variation}: no scene after {MAX_TRIES} tries: "
        "use another seed"
    )


def _meant(program: Program, domain: Domain, blocks: Sequence[Block]) -> tuple[Move, ...] | None:
    """The moves of a program; None if a description fits no block or several."""
    moves = []
    for step in program:
        moved, reference = _called(step.object, blocks), _called(step.reference, blocks)
        if len(moved) != 1 or len(reference) != 1:
            return None
        moves.append(Move(domain.action(step.action), moved[0], reference[0]))
    return tuple(moves)


def _called(description: Sequence[str], blocks: Sequence[Block]) -> list[int]:
    return [
        index
        for index, block in enumerate(blocks)
        if set(description) <= set(block.values.values())
    ]


def _has_room(arrangement: Arrangement, moves: Sequence[Move]) -> bool:
    for move in moves:
        if not arrangement.allowed(move):
            return False
        arrangement = arrangement.after(move)
    return True
