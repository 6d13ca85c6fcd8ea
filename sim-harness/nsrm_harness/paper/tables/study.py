"""Defines the study behind the tables: splits, families of models, and their sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from nsrm_harness.data.generate import SPLITS, Settings
from nsrm_harness.learning.baseline.train import BaselineConfig
from nsrm_harness.learning.config import QUICK_CONFIG, StageConfig, TrainingConfig, read_config

FULL, QUICK = "full", "quick"


@dataclass(frozen=True)
class Family:
    """Models with the same training data."""

    name: str
    train: str
    validation: str
    judged: tuple[str, ...]
    """The splits on which they are judged."""


FAMILIES = (
    Family(
        "full",
        "train",
        "validation",
        (
            "train",
            "test",
            "steps_3",
            "steps_4",
            "steps_5",
            "steps_6",
            "steps_8",
            "objects_8",
            "objects_10",
            "paraphrase",
        ),
    ),
    # Only single attribute values, and without the novel pairs (Tables IV and VI).
    Family(
        "restricted",
        "train_restricted",
        "validation_restricted",
        ("novel_pairs", "multi_attribute"),
    ),
)
JUDGED = tuple(split for family in FAMILIES for split in family.judged)
"""All judged splits, in the order of the report."""


@dataclass(frozen=True)
class Study:
    """The sizes and settings of a study."""

    name: str
    seeds: tuple[int, ...]
    """Seeds of the models; the data has its own seed."""
    data_seed: int
    counts: Mapping[str, int]
    """Numbers of episodes by split; `SPLITS` gives those that are missing here."""
    calibration_scenes: int
    config: TrainingConfig
    baseline: BaselineConfig
    refusals: int
    """Number of sentences to refuse of each kind."""

    def settings(self, split: str) -> Settings:
        """Settings of a split's data file, without the final images, which nothing reads."""
        default = SPLITS[split]
        count = self.counts.get(split, default.count)
        return replace(default, count=count, seed=self.data_seed, final_image=False)

    def splits(self) -> list[str]:
        """Names of all splits that have files."""
        names = [name for f in FAMILIES for name in (f.train, f.validation, *f.judged)]
        return list(dict.fromkeys(names))


def full_study(data_seed: int = 1) -> Study:
    """Three seeds, on about as much data as the paper's."""
    return Study(
        name=FULL,
        seeds=(0, 1, 2),
        data_seed=data_seed,
        counts={},
        calibration_scenes=400,
        config=TrainingConfig(),
        baseline=BaselineConfig(),
        refusals=1000,
    )


def quick_study(data_seed: int = 1) -> Study:
    """One seed on a fifth of the data: shows that all parts work together."""
    counts = dict.fromkeys(SPLITS, 8)
    # What something is chosen or expected by.
    chosen = ("validation", "validation_restricted", "novel_pairs", "multi_attribute", "objects_10")
    counts |= dict.fromkeys(chosen, 20)
    counts |= {"train": 500, "train_restricted": 500, "test": 60}
    few = StageConfig(epochs=3, learning_rate=3e-3, batch=32)
    return Study(
        name=QUICK,
        seeds=(0,),
        data_seed=data_seed,
        counts=counts,
        calibration_scenes=60,
        config=read_config(QUICK_CONFIG),
        baseline=replace(BaselineConfig(), single=few, joint=few, simulator=few, attempts=1),
        refusals=4,
    )
