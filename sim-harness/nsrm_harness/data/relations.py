"""Describes blocks by where they stand, as a person who sees the scene would: "the red block left
of the yellow one".

An action's relation holds between two blocks if the one is in the direction in which the action
would put it, seen from the other. A superlative compares the distances between centres. A
description is only used if it clearly holds for its block and clearly for no other one.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.moves import Move, target
from nsrm_harness.data.programs import Descriptions, unique_descriptions
from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import everyday_of
from nsrm_harness.domain.program import SUPERLATIVES, Relation, Step
from nsrm_harness.simulation.blocks import block_from_attributes

#: A relation clearly holds up to this angle between the two directions, and clearly does not from
#: the other one on, as cosines.
HOLDS, DOES_NOT = float(np.cos(np.radians(35.0))), float(np.cos(np.radians(65.0)))
#: Of two distances the longer one is clearly longer from this ratio on, and they are about the same
#: up to the other one.
LONGER, SAME = 1.25, 1.04
#: Share of a distance that is vertical from which on one block stands on the other: nobody calls it
#: the nearest then.
STEEP = 0.5
#: Largest number of attribute values in a description.
MOST_VALUES = 2


@dataclass(frozen=True)
class Described:
    """A description."""

    concepts: tuple[str, ...]
    relations: tuple[Relation, ...]
    #: Which one of those that fit: the name of an extreme.
    which: str | None = None


def step_of(action: str, moved: Described, reference: Described) -> Step:
    """The step with these descriptions."""
    return Step(
        action,
        moved.concepts,
        reference.concepts,
        moved.relations,
        reference.relations,
        moved.which,
        reference.which,
    )


def kinds_of(values: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The sets of a block's values that a description may have, and none."""
    return [
        kind for size in range(MOST_VALUES + 1) for kind in itertools.combinations(values, size)
    ]


class RelatedDescriptions:
    """The descriptions with relations of the blocks in an episode's initial scene."""

    def __init__(self, domain: Domain, truth: Truth, names: Collection[str] | None = None) -> None:
        """`names`: the relations; all of the domain by default"""
        every = everyday_of(domain).states()
        known = [name for name in every if names is None or name in names]
        self._blocks = [block_from_attributes(domain, values) for values in truth.attributes]
        self._poses = truth.initial_poses
        unique = unique_descriptions(domain, self._blocks, Descriptions(1, MOST_VALUES))
        self._plain = [list(kinds.values()) for kinds in unique]
        self._cosines = {
            name: self._cosine(Move(domain.action(name), 0, 0))
            for name in known
            if name not in SUPERLATIVES
        }
        places = np.array([pose.position for pose in self._poses])
        between = places[:, None] - places
        distances = np.linalg.norm(between, axis=-1)
        self._stacked = np.abs(between[..., 2]) > STEEP * distances
        remoteness = (distances, 1.0 / np.where(distances > 0.0, distances, np.inf))
        #: How far each block is from the one that a superlative names, seen from each other one:
        #: distances or their inverses, `[n, n]`.
        self._remoteness = {
            name: each for name, each in zip(SUPERLATIVES, remoteness, strict=True) if name in known
        }

    def _cosine(self, move: Move) -> np.ndarray:
        """How far each block is in the action's direction from each other one, `[n, n]`."""
        places = np.array([pose.position for pose in self._poses])
        count = len(places)
        found = np.full((count, count), -1.0)
        for block, other in itertools.permutations(range(count), 2):
            goal = target(Move(move.action, block, other), self._blocks, self._poses)
            put, stands = np.array(goal.position) - places[other], places[block] - places[other]
            found[block, other] = put @ stands / np.linalg.norm(put) / np.linalg.norm(stands)
        return found

    def of(self, block: int, links: int) -> list[Described]:
        """All descriptions of a block with so many relations, one or two."""
        if links == 1:
            return list(self._related(block, self._kinds(block), self._plain_anchors()))
        anchors = [list(self._anchors(other)) for other in range(len(self._blocks))]
        return list(self._related(block, self._kinds(block), anchors))

    def _anchors(self, block: int) -> Iterator[Described]:
        """Descriptions with values and one relation."""
        kinds = [kind for kind in self._kinds(block) if kind]
        return self._related(block, kinds, self._plain_anchors())

    def _plain_anchors(self) -> list[list[Described]]:
        return [[Described(values, ()) for values in plain] for plain in self._plain]

    def _kinds(self, block: int) -> list[tuple[str, ...]]:
        return kinds_of(tuple(self._blocks[block].values.values()))

    def _related(
        self, block: int, kinds: list[tuple[str, ...]], anchors: list[list[Described]]
    ) -> Iterator[Described]:
        yield from self._directed(block, kinds, anchors)
        yield from self._compared(block, kinds, anchors)

    def _directed(
        self, block: int, kinds: list[tuple[str, ...]], anchors: list[list[Described]]
    ) -> Iterator[Described]:
        for name, cosines in self._cosines.items():
            for other, described in enumerate(anchors):
                if not described or cosines[block, other] < HOLDS:
                    continue
                rivals = [
                    set(self._blocks[index].values.values())
                    for index in np.flatnonzero(cosines[:, other] > DOES_NOT)
                    if index != block
                ]
                for kind in kinds:
                    if not any(set(kind) <= values for values in rivals):
                        for anchor in described:
                            relation = Relation(name, anchor.concepts)
                            yield Described(kind, (relation, *anchor.relations))

    def _compared(
        self, block: int, kinds: list[tuple[str, ...]], anchors: list[list[Described]]
    ) -> Iterator[Described]:
        """Descriptions by superlatives. There are others to compare the block with."""
        for name, remoteness in self._remoteness.items():
            for other, described in enumerate(anchors):
                if not described or block == other or self._stacked[block, other]:
                    continue
                for kind in kinds:
                    others = [at for at in self._fitting(kind, other) if at != block]
                    nearest = min((remoteness[at, other] for at in others), default=0.0)
                    if nearest >= LONGER * remoteness[block, other]:
                        for anchor in described:
                            relation = Relation(name, anchor.concepts)
                            yield Described(kind, (relation, *anchor.relations))

    def _fitting(self, kind: tuple[str, ...], anchor: int) -> list[int]:
        """The blocks with these values, without the anchor."""
        return [
            index
            for index, block in enumerate(self._blocks)
            if index != anchor and set(kind) <= set(block.values.values())
        ]

    def misleading(self) -> list[Described]:
        """Descriptions with one relation that hold for no block, or clearly for several."""
        found: list[Described] = []
        every = [set(block.values.values()) for block in self._blocks]
        kinds = sorted({kind for block in range(len(every)) for kind in self._kinds(block)})
        for name, cosines in self._cosines.items():
            for other, described in enumerate(self._plain_anchors()):
                for kind in kinds:
                    fitting = [
                        cosines[block, other]
                        for block, values in enumerate(every)
                        if block != other and set(kind) <= values
                    ]
                    none = all(cosine < DOES_NOT for cosine in fitting)
                    if none or sum(cosine > HOLDS for cosine in fitting) > 1:
                        found += _each(kind, name, described)
        for name, remoteness in self._remoteness.items():
            for other, described in enumerate(self._plain_anchors()):
                for kind in kinds:
                    every = sorted(remoteness[at, other] for at in self._fitting(kind, other))
                    if not every or (len(every) > 1 and every[1] <= SAME * every[0]):
                        found += _each(kind, name, described)
        return found


def _each(kind: tuple[str, ...], name: str, anchors: list[Described]) -> list[Described]:
    """A description by a relation to each of the anchors."""
    return [Described(kind, (Relation(name, anchor.concepts),)) for anchor in anchors]
