"""What is put next to another block, on two of its sides at once, or at a distance that is named,
or moved from where it is, in scenes: whether it ends there.

Judged by the ground truth: the right block, its centre near one of the places where the
demonstrator would put it, and its base apart from that of every other block.
"""

from __future__ import annotations

from dataclasses import dataclass

import nsrm
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.data.between import between_of, between_programs
from nsrm_harness.data.compounds import Put, compound_programs
from nsrm_harness.data.distances import spaced_programs
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.data.seeds import generator
from nsrm_harness.data.shifts import shifted_programs
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program
from nsrm_harness.evaluation.on_table import is_clear

#: How far the centre of a block is at most from where it may end, metres. What a block that carries
#: another one is beside is seen in part, and less precisely.
OFF_M = 0.03
#: The same along the table, where the distance is named.
DISTANT_OFF_M = 0.01
#: Number of sentences of each kind about an episode.
TIMES = 3


@dataclass(frozen=True, eq=False)
class PutBeside:
    """A sentence that puts a block of an episode beside another one, or moves it from its place."""

    episode: int
    put: Put
    #: Centres and edges of all blocks, ``[n, 3]``, metres.
    places_m: NDArray[np.float64]
    edges_m: NDArray[np.float64]

    @property
    def program(self) -> Program:
        """The program that it means."""
        return (self.put.step,)

    def is_done_by(self, plan: nsrm.Plan) -> bool:
        """Whether the plan puts that block, and no other, to one of these places."""
        moved = [(step.object_id, step.reference_id) for step in plan.steps]
        if moved != [(self.put.moved + 1, self.put.reference + 1)]:
            return False
        place = np.array(plan.steps[0].position)
        off_m = np.array(self.put.goals) - place
        is_near = np.linalg.norm(off_m, axis=1) < OFF_M
        if self.put.step.distance_mm is not None:
            is_near &= np.linalg.norm(off_m[:, :2], axis=1) < DISTANT_OFF_M
        is_there = bool(is_near.any())
        return is_there and is_clear(place, self.put.moved, self.places_m, self.edges_m)


def put_beside(domain: Domain, judge: GroundTruth, seed: int) -> dict[str, list[PutBeside]]:
    """Up to `TIMES` sentences of each kind about each episode, by the name of their set."""
    sets: dict[str, list[PutBeside]] = {}
    if domain.compounds is not None:
        sets |= {"next to in scenes": [], "diagonally in scenes": []}
    if between_of(domain) is not None:
        sets["between in scenes"] = []
    if domain.distances is not None:
        sets |= {"distances in scenes": [], "shifts in scenes": []}
    for index in range(len(judge)):
        rng, truth = generator(seed, "compounds", index), judge.truth(index)
        places_m = np.array([pose.position for pose in truth.initial_poses])
        found = list(compound_programs(domain, truth))
        kinds = {
            "next to in scenes": [put for put in found if put.is_any],
            "diagonally in scenes": [put for put in found if not put.is_any],
            "between in scenes": list(between_programs(domain, truth)),
            "distances in scenes": list(
                spaced_programs(domain, truth, generator(seed, "distances", 1 + index))
            ),
            "shifts in scenes": list(
                shifted_programs(domain, truth, generator(seed, "shifts", 1 + index))
            ),
        }
        for name, chosen in sets.items():
            every = kinds[name]
            for at in rng.permutation(len(every))[:TIMES]:
                chosen.append(PutBeside(index, every[at], places_m, truth.edges_m))
    return sets
