"""What is put on the table in scenes: whether it ends there, and touches nothing else.

Judged by the ground truth: the right block, half its height above the table, and its base apart
from that of every other block.
"""

from __future__ import annotations

from dataclasses import dataclass

import nsrm
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.data.on_table import table_programs
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program

#: How far the centre of a block that stands on the table is at most from half its height, metres.
OFF_M = 0.01


def is_clear(
    place: NDArray[np.float64],
    block: int,
    places_m: NDArray[np.float64],
    edges_m: NDArray[np.float64],
) -> bool:
    """Whether the base of a block at a place is apart from that of every other block.

    * `block`: its index
    * `places_m`, `edges_m`: centres and edges of all blocks, ``[n, 3]``, metres
    """
    others = np.arange(len(edges_m)) != block
    apart_m = np.abs(places_m[others, :2] - place[:2])
    touching_m = 0.5 * (edges_m[others, :2] + edges_m[block, :2])
    return bool(np.all(np.any(apart_m > touching_m, axis=1)))


@dataclass(frozen=True, eq=False)
class PutOnTable:
    """A sentence that puts a block of an episode on the table."""

    episode: int
    program: Program
    #: Id of the block; None if it must be refused.
    block: int | None
    #: Centres and edges of all blocks, ``[n, 3]``, metres.
    places_m: NDArray[np.float64]
    edges_m: NDArray[np.float64]

    def is_done_by(self, plan: nsrm.Plan) -> bool:
        """Whether the plan puts that block, and no other, where there is room on the table."""
        if self.block is None or [step.object_id for step in plan.steps] != [self.block]:
            return False
        place = np.array(plan.steps[0].position)
        height_m = 0.5 * self.edges_m[self.block - 1, 2]
        is_there = bool(abs(place[2] - height_m) < OFF_M)
        return is_there and is_clear(place, self.block - 1, self.places_m, self.edges_m)


def put_on_table(domain: Domain, judge: GroundTruth) -> dict[str, list[PutOnTable]]:
    """A sentence for each block that carries no other one, by the name of its set: of those on
    another block, and of those that stand on the table already."""
    sets: dict[str, list[PutOnTable]] = {"on the table in scenes": [], "on the table already": []}
    lifted, there = sets.values()
    for index in range(len(judge)):
        truth = judge.truth(index)
        places_m = np.array([pose.position for pose in truth.initial_poses])
        for step, block, stands_high in table_programs(domain, truth):
            meant = block if stands_high else None
            said = PutOnTable(index, (step,), meant, places_m, truth.edges_m)
            (lifted if stands_high else there).append(said)
    return sets
