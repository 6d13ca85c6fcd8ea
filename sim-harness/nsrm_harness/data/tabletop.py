"""Draws the scene of a seed, and a sentence that fits it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.moves import Arrangement
from nsrm_harness.data.programs import Descriptions, sample_blocks, sample_task
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.simulation.layout import LayoutError, sample_layout

BLOCKS = (4, 6)
STEPS = (1, 2)
MAX_TRIES = 100


@dataclass(frozen=True)
class Tabletop:
    """An initial arrangement of blocks, and a sentence."""

    arrangement: Arrangement
    sentence: str


def tabletop(domain: Domain, seed: int) -> Tabletop:
    """Draws the scene of `seed`, which does not depend on the sentence used in it.

    The sentence commands one or two steps that have room in the scene.
    """
    rng = generator(seed, "demo", 0)
    for _ in range(MAX_TRIES):
        blocks = sample_blocks(rng, domain, _between(rng, BLOCKS))
        try:
            arrangement = Arrangement.on_table(blocks, sample_layout(rng, blocks))
        except LayoutError:
            continue
        task = sample_task(rng, domain, arrangement, _between(rng, STEPS), Descriptions(1, 2))
        if task is not None:
            return Tabletop(arrangement, Grammar(domain).plain(task.program))
    raise HarnessError(f"seed {seed}: no scene with room for a step after {MAX_TRIES} tries")


def _between(rng: np.random.Generator, bounds: tuple[int, int]) -> int:
    return int(rng.integers(bounds[0], bounds[1] + 1))
