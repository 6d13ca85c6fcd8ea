"""Describes several blocks that are moved, as a person who sees the scene would: "all red blocks",
"both of the small ones"."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.relations import MOST_VALUES, Described, kinds_of, step_of
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import ALL, BOTH, Program, Step
from nsrm_harness.simulation.blocks import block_from_attributes

#: Number of objects that "both" means.
BOTH_COUNT = 2
#: Largest number of blocks that are moved: there is no room for longer rows and higher towers.
MOST_MOVED = 3


@dataclass(frozen=True)
class Several:
    """A program of one step that moves several blocks of a scene."""

    program: Program
    #: Ids of the blocks; none if it must be refused.
    moved: tuple[int, ...]
    #: Id of the block that the first of them is moved to.
    reference: int


def several_programs(
    domain: Domain, truth: Truth, rng: np.random.Generator, count: int
) -> tuple[list[Several], list[Several]]:
    """So many random programs about an episode's initial scene, and as many that fit none of its
    blocks, or not two if both are meant. None if there are no such programs."""
    true: list[Several] = []
    untrue: list[Several] = []
    for step, reference, moved in several_steps(domain, values_of(domain, truth)):
        if (step.object_which == BOTH and len(moved) != BOTH_COUNT) or not moved:
            untrue.append(Several((step,), (), reference + 1))
        elif 1 < len(moved) <= MOST_MOVED:
            ids = tuple(block + 1 for block in moved)
            true.append(Several((step,), ids, reference + 1))
    return drawn(domain, true, rng, count), drawn(domain, untrue, rng, count)


def has_stack(truth: Truth) -> bool:
    """Whether a block stands on another one, which it then hides in part."""
    heights = [pose.position[2] for pose in truth.initial_poses]
    return any(z > edges[2] for z, edges in zip(heights, truth.edges_m, strict=True))


def values_of(domain: Domain, truth: Truth) -> list[tuple[str, ...]]:
    """The values of each block of an episode."""
    blocks = [block_from_attributes(domain, values) for values in truth.attributes]
    return [tuple(block.values.values()) for block in blocks]


def several_steps(
    domain: Domain, values: list[tuple[str, ...]]
) -> Iterator[tuple[Step, int, list[int]]]:
    """Steps of the first action that move several blocks, each with the index of its reference,
    which its description fits alone, and those of the blocks that fit, apart from the reference."""
    every = sorted({kind for own in values for kind in kinds_of(own)})
    for reference, own in enumerate(values):
        for place in kinds_of(own):
            if fitting(values, place) != [reference]:
                continue
            for kind in every:
                moved = [at for at in fitting(values, kind) if at != reference]
                for which in (ALL, BOTH):
                    described = Described(kind, (), which)
                    step = step_of(domain.actions[0].name, described, Described(place, ()))
                    yield step, reference, moved


def fitting(values: list[tuple[str, ...]], kind: tuple[str, ...]) -> list[int]:
    return [at for at, own in enumerate(values) if set(kind) <= set(own)]


def drawn(
    domain: Domain, every: list[Several], rng: np.random.Generator, count: int
) -> list[Several]:
    """So many of them, each with any action."""
    drawn: list[Several] = []
    for at in rng.integers(len(every), size=count) if every else ():
        action = domain.actions[int(rng.integers(len(domain.actions)))].name
        (step,) = every[int(at)].program
        drawn.append(replace(every[int(at)], program=(replace(step, action=action),)))
    return drawn


def with_several(program: Program, rng: np.random.Generator) -> tuple[Program, Program]:
    """The program with several objects that are moved in one of its steps, as `ALL` or `BOTH`, and
    the same with several references there, which must be refused."""
    at = int(rng.integers(len(program)))
    which = (ALL, BOTH)[int(rng.integers(2))]
    step = program[at]
    told = (
        replace(step, object_which=which, object=_some(step.object, rng)),
        replace(step, reference_which=which, reference=_some(step.reference, rng)),
    )
    true, untrue = ((*program[:at], each, *program[at + 1 :]) for each in told)
    return true, untrue


def _some(concepts: tuple[str, ...], rng: np.random.Generator) -> tuple[str, ...]:
    """A part of a description's values, perhaps none."""
    kept = rng.permutation(len(concepts))[: int(rng.integers(0, MOST_VALUES + 1))]
    return tuple(concepts[index] for index in sorted(kept))
