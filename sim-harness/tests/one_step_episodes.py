"""Episodes of one step, half of them with blocks that stand on others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from nsrm_harness import domain as domains
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.data.ground_truth import GroundTruth, Truth

ONE_STEP = replace(
    SPLITS["validation"],
    count=16,
    seed=9,
    steps=(1, 1),
    stacks=0.5,
    final_image=False,
    renderer="pybullet",
)


def truths_of(path: Path, count: int, seed: int) -> list[Truth]:
    """The ground truth of so many of these episodes, which are written to a file."""
    assert generate(replace(ONE_STEP, count=count, seed=seed), domains.load(), path)
    with GroundTruth(path) as judge:
        return [judge.truth(number) for number in range(len(judge))]
