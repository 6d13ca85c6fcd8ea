"""Draws random scenes, and programs that are possible in them.

A description is a set of attribute values that only one block of the scene has. Its attribute types
are drawn before the blocks, so that rare descriptions ("the lego block" with a single lego block)
occur often enough to be learned.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data.moves import Arrangement, Move
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step, canonical
from nsrm_harness.simulation.blocks import Block, block_from_attributes

#: Share of scenes that are made to have a block with a unique value of some attribute type.
ODD_ONE_OUT = 0.25
#: Share of later steps that name a block of an earlier step, if possible.
REUSE = 0.6
#: Number of draws in one scene before another scene is tried.
MAX_DRAWS = 50
#: Number of shares into which 1-step programs are divided, by hash.
SHARES = 5
#: The shares of each set, which are disjoint.
SHARES_OF = {"train": (0, 1, 2), "validation": (3,), "test": (4,)}

#: For each block its unique descriptions: attribute types to values.
Unique = list[dict[tuple[str, ...], tuple[str, ...]]]


@dataclass(frozen=True)
class Descriptions:
    """How objects are described: the number of attribute values in a description."""

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
    """Draws `count` blocks with random attribute values; none has all values of a set in `exclude`,
    and the first one has those of a set in `novel`."""
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
        raise EpisodeSettingsError(
            "almost every combination of attribute values is excluded: exclude fewer"
        )
    order = rng.permutation(count)
    return tuple(blocks[index] for index in order)


def unique_descriptions(
    domain: Domain, blocks: Sequence[Block], descriptions: Descriptions
) -> Unique:
    """For each block its unique descriptions: attribute types to values."""
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
    about: Collection[int] = (),
) -> Task | None:
    """Draws a program with `steps` steps that is possible, or returns None if none was found.

    `shares`: the shares from which 1-step programs are drawn; longer programs are not limited.
    `novel`: some description has all values of one of these.
    `about`: indices of blocks; the first step names one of them, if such a step is possible.
    """
    # Half of the programs use only the shortest descriptions, so that there are
    # enough for the first
    # stage of the curriculum (section IV-F).
    most = int(rng.integers(descriptions.least, descriptions.most + 1))
    unique = unique_descriptions(domain, arrangement.blocks, Descriptions(descriptions.least, most))
    first = _possible(domain, arrangement, unique)
    first = [move for move in first if move.moved in about or move.reference in about] or first
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
    """All descriptions of a program."""
    return [said for step in program for said in (step.object, step.reference)]


def share(program: Program) -> int:
    """The share, of `SHARES`, of a program; the same on every machine."""
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
    """The allowed moves of blocks that can be described."""
    return arrangement.moves(domain, [index for index, kinds in enumerate(unique) if kinds])


def _preferred(rng: np.random.Generator, possible: list[Move], earlier: list[Move]) -> list[Move]:
    """Moves of blocks that have not been moved yet, if there are any, so that the final scene shows
    every step. Often only those that involve an earlier block."""
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
    """Draws a move and the attribute types that describe its two objects: first the action, then
    the types, then one of the remaining moves."""
    names = list(dict.fromkeys(move.action.name for move in moves))
    name = names[int(rng.integers(len(names)))]
    moves = [move for move in moves if move.action.name == name]
    moved = _sample_kind(rng, [unique[move.moved] for move in moves])
    moves = [move for move in moves if moved in unique[move.moved]]
    reference = _sample_kind(rng, [unique[move.reference] for move in moves])
    moves = [move for move in moves if reference in unique[move.reference]]
    return moves[int(rng.integers(len(moves)))], moved, reference


def _sample_kind(rng: np.random.Generator, descriptions: Unique) -> tuple[str, ...]:
    """Draws first the number of attribute values, then their types."""
    kinds = list(dict.fromkeys(kind for each in descriptions for kind in each))
    sizes = sorted({len(kind) for kind in kinds})
    size = sizes[int(rng.integers(len(sizes)))]
    kinds = sorted(kind for kind in kinds if len(kind) == size)
    return kinds[int(rng.integers(len(kinds)))]
