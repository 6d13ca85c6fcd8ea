"""Says which one of several blocks is meant, as a person who sees the scene would: "the leftmost
red block".

An extreme is the block that lies farthest in the direction in which an action puts things, by the
places of centres, or the one of the largest or smallest volume. It is only used if it is clear.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.relations import Described, kinds_of
from nsrm_harness.domain import Domain
from nsrm_harness.domain.domain import Action
from nsrm_harness.simulation.blocks import block_from_attributes

#: One block lies clearly farther than another one from this distance on, and about as far up to the
#: other one, metres.
FARTHER_M, SAME_M = 0.025, 0.01
#: Least ratio of two volumes of which one is clearly the larger.
LARGER = 1.25


class ExtremeDescriptions:
    """The descriptions by extremes of the blocks in an episode's initial scene."""

    def __init__(self, domain: Domain, truth: Truth) -> None:
        blocks = [block_from_attributes(domain, values) for values in truth.attributes]
        self._values = [tuple(block.values.values()) for block in blocks]
        places = np.array([pose.position for pose in truth.initial_poses])
        volumes = np.array([np.prod(block.edges_m) for block in blocks])
        reach = {action.name: places @ _direction(action) for action in domain.actions}
        # A size that is clearly larger counts as one that lies clearly farther.
        step = FARTHER_M / np.log(LARGER)
        reach |= {"Largest": step * np.log(volumes), "Smallest": -step * np.log(volumes)}
        named = zip(domain.extremes, domain.extreme_words(), strict=True)
        #: How far each block lies in the direction of each extreme, by its name.
        self._reach = {name: reach[key] for key, name in named}

    def of(self, block: int) -> list[Described]:
        """All descriptions of a block among several that fit."""
        return [
            Described(kind, (), name)
            for kind in kinds_of(self._values[block])
            for name, first, farther in self._farthest(kind)
            if first == block and farther >= FARTHER_M
        ]

    def unclear(self) -> list[Described]:
        """Descriptions of two blocks that lie about as far."""
        return [
            Described(kind, (), name)
            for kind in sorted({kind for values in self._values for kind in kinds_of(values)})
            for name, _, farther in self._farthest(kind)
            if farther <= SAME_M
        ]

    def absent(self) -> list[Described]:
        """Descriptions that fit no block, of values that some have."""
        every = sorted(set(itertools.product(*zip(*self._values, strict=True))))
        return [
            Described(kind, (), name)
            for kind in every
            if not self._fitting(kind)
            for name in self._reach
        ]

    def ordered(self) -> Iterator[tuple[tuple[str, ...], dict[str, list[tuple[int, float]]]]]:
        """For all values that several blocks have, by the name of each extreme: the blocks from the
        farthest on, and how far each lies in its direction."""
        for kind in sorted({kind for values in self._values for kind in kinds_of(values)}):
            if len(self._fitting(kind)) > 1:
                yield kind, self._order(kind)

    def _order(self, kind: tuple[str, ...]) -> dict[str, list[tuple[int, float]]]:
        fitting = self._fitting(kind)
        return {
            name: sorted(((at, float(reach[at])) for at in fitting), key=lambda each: -each[1])
            for name, reach in self._reach.items()
        }

    def _farthest(self, kind: tuple[str, ...]) -> Iterator[tuple[str, int, float]]:
        """For each extreme, the block of these values that lies farthest and how much farther it
        lies than the next one, if there are several."""
        for name, order in self._order(kind).items():
            if len(order) > 1:
                (first, reach), (_, second), *_ = order
                yield name, first, reach - second

    def _fitting(self, kind: tuple[str, ...]) -> list[int]:
        return [at for at, values in enumerate(self._values) if set(kind) <= set(values)]


def _direction(action: Action) -> np.ndarray:
    """The unit vector in which an action puts things."""
    return np.array([0.0, 0.0, 1.0] if action.direction is None else [*action.direction, 0.0])
