"""Drawing of scenes and of programs that can be carried out in them.

A description is a set of attribute values that only one block of the scene has.
Which values it names is drawn before the blocks, so that rare descriptions ("the
lego block" where there is one lego block) occur often enough to be learned.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data.moves import Arrangement, Move
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step, canonical
from nsrm_harness.simulation.blocks import Block, block_from_attributes

#: How often a scene is made to have a block that alone has its value of some
#: attribute type.
ODD_ONE_OUT = 0.25
#: How often a later step names a block that an earlier one named, where it can.
REUSE = 0.6
#: Steps drawn in one scene before another scene is tried.
MAX_DRAWS = 50
#: 1-step programs fall into this many shares, by hash.
SHARES = 5
#: Which shares are whose: no 1-step command of one of these is in another.
SHARES_OF = {"train": (0, 1, 2), "validation": (3,), "test": (4,)}

#: For each block the descriptions that fit no other: attribute types to values.
Unique = list[dict[tuple[str, ...], tuple[str, ...]]]


@dataclass(frozen=True)
class Descriptions:
    """How objects are named: how many attribute values a description has."""

    least: int
    most: int


@dataclass(frozen=True)
class Task:
    """A program and the moves that it commands."""

    program: Program
    moves: tuple[Move, ...]


def sample_blocks(
    rng: np.random.Generator,
    domain: Domain,
    count: int,
    exclude: Sequence[frozenset[str]] = (),
    novel: Sequence[frozenset[str]] = (),
) -> tuple[Block, ...]:
    """`count` blocks with random attribute values; none has all values of a set in `exclude`,
    the first one those of a set in `novel`."""
    odd = rng.random() < ODD_ONE_OUT
    attribute = domain.attributes[int(rng.integers(len(domain.attributes)))]
    alone = attribute.values[int(rng.integers(len(attribute.values)))].name
    blocks: list[Block] = []
    for _ in range(MAX_DRAWS * count):
        if len(blocks) == count:
            break
        values = {
            each.name: each.values[int(rng.integers(len(each.values)))].name
            for each in domain.attributes
        }
        if novel and not blocks:
            if not any(pair <= set(values.values()) for pair in novel):
                continue
        elif odd and (values[attribute.name] == alone) != (not blocks):
            continue
        if not any(pair <= set(values.values()) for pair in exclude):
            blocks.append(block_from_attributes(domain, values))
    if len(blocks) < count:
        raise EpisodeSettingsError("almost every combination of attribute values is excluded")
    order = rng.permutation(count)
    return tuple(blocks[index] for index in order)


def unique_descriptions(
    domain: Domain, blocks: Sequence[Block], descriptions: Descriptions
) -> Unique:
    """For each block the descriptions that fit no other: attribute types to values."""
    types = [attribute.name for attribute in domain.attributes]
    kinds = [
        kind
        for size in range(descriptions.least, descriptions.most + 1)
        for kind in itertools.combinations(types, size)
    ]
    named = [
        {kind: tuple(block.values[name] for name in kind) for kind in kinds} for block in blocks
    ]
    return [
        {
            kind: values
            for kind, values in own.items()
            if sum(other[kind] == values for other in named) == 1
        }
        for own in named
    ]


def sample_task(
    rng: np.random.Generator,
    domain: Domain,
    arrangement: Arrangement,
    steps: int,
    descriptions: Descriptions,
    shares: Sequence[int] | None = None,
    novel: Sequence[frozenset[str]] = (),
) -> Task | None:
    """A program of `steps` steps that can be carried out, or None if none was found.

    `shares`: of the 1-step programs, those that may be drawn; others are not bound.
    `novel`: some description has all values of one of these.
    """
    # Half of the programs use the shortest descriptions only, so that there are
    # enough for the first stage of the curriculum (section IV-F).
    most = int(rng.integers(descriptions.least, descriptions.most + 1))
    unique = unique_descriptions(domain, arrangement.blocks, Descriptions(descriptions.least, most))
    first = _possible(domain, arrangement, unique)
    for _ in range(MAX_DRAWS):
        task = _sample_steps(rng, domain, arrangement, first, steps, unique)
        if task is None:
            return None
        if novel and not any(pair <= set(said) for pair in novel for said in said_in(task.program)):
            continue
        if steps > 1 or shares is None or share(task.program) in shares:
            return task
    return None


def said_in(program: Program) -> list[tuple[str, ...]]:
    """Every description of a program."""
    return [said for step in program for said in (step.object, step.reference)]


def share(program: Program) -> int:
    """Which of the `SHARES` shares a program falls into; the same everywhere."""
    digest = hashlib.sha256(canonical(program).encode()).digest()
    return int.from_bytes(digest[:8], "little") % SHARES


def _sample_steps(
    rng: np.random.Generator,
    domain: Domain,
    arrangement: Arrangement,
    first: list[Move],
    steps: int,
    unique: Unique,
) -> Task | None:
    program: list[Step] = []
    moves: list[Move] = []
    possible = first
    while possible:
        move, moved, reference = _sample_move(rng, _preferred(rng, possible, moves), unique)
        program.append(
            Step(move.action.name, unique[move.moved][moved], unique[move.reference][reference])
        )
        moves.append(move)
        if len(program) == steps:
            return Task(tuple(program), tuple(moves))
        arrangement = arrangement.after(move)
        possible = _possible(domain, arrangement, unique)
    return None


def _possible(domain: Domain, arrangement: Arrangement, unique: Unique) -> list[Move]:
    """The moves that may be commanded on blocks that can be named."""
    return arrangement.moves(domain, [index for index, kinds in enumerate(unique) if kinds])


def _preferred(rng: np.random.Generator, possible: list[Move], earlier: list[Move]) -> list[Move]:
    """Moves of blocks not moved yet, where there are any: what the final scene shows
    of a step is not undone. Often only those that go on with an earlier block."""
    moved = {move.moved for move in earlier}
    fresh = [move for move in possible if move.moved not in moved] or possible
    named = moved | {move.reference for move in earlier}
    if not named or rng.random() >= REUSE:
        return fresh
    return [move for move in fresh if move.moved in named or move.reference in named] or fresh


def _sample_move(
    rng: np.random.Generator,
    moves: list[Move],
    unique: Unique,
) -> tuple[Move, tuple[str, ...], tuple[str, ...]]:
    """A move and the attribute types by which its two objects are named: first the
    action, then the types, then one of the moves that they leave."""
    names = list(dict.fromkeys(move.action.name for move in moves))
    name = names[int(rng.integers(len(names)))]
    moves = [move for move in moves if move.action.name == name]
    moved = _sample_kind(rng, [unique[move.moved] for move in moves])
    moves = [move for move in moves if moved in unique[move.moved]]
    reference = _sample_kind(rng, [unique[move.reference] for move in moves])
    moves = [move for move in moves if reference in unique[move.reference]]
    return moves[int(rng.integers(len(moves)))], moved, reference


def _sample_kind(rng: np.random.Generator, descriptions: Unique) -> tuple[str, ...]:
    """First how many attribute values, then of which types."""
    kinds = list(dict.fromkeys(kind for each in descriptions for kind in each))
    sizes = sorted({len(kind) for kind in kinds})
    size = sizes[int(rng.integers(len(sizes)))]
    kinds = sorted(kind for kind in kinds if len(kind) == size)
    return kinds[int(rng.integers(len(kinds)))]
