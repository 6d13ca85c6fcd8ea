"""What the tables rest on: splits, families of models, and how many of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from nsrm_harness.data.generate import SPLITS, Settings
from nsrm_harness.learning.baseline.train import BaselineConfig
from nsrm_harness.learning.config import QUICK_CONFIG, StageConfig, TrainingConfig, read_config

FULL, QUICK = "full", "quick"


@dataclass(frozen=True)
class Family:
    """Models of the same training data."""

    name: str
    train: str
    validation: str
    judged: tuple[str, ...]
    """Splits on which they are judged, by the names that the figures have."""


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
    # Single attribute values alone and without the novel pairs (Tables IV and VI).
    Family(
        "restricted",
        "train_restricted",
        "validation_restricted",
        ("novel_pairs", "multi_attribute"),
    ),
)
JUDGED = tuple(split for family in FAMILIES for split in family.judged)
"""All splits with figures, in the order in which they are told."""


@dataclass(frozen=True)
class Study:
    """How much of everything."""

    name: str
    seeds: tuple[int, ...]
    """Of the models; the data has one of its own."""
    data_seed: int
    counts: Mapping[str, int]
    """Episodes of each split; those that aren't named have as many as `SPLITS` says."""
    calibration_scenes: int
    config: TrainingConfig
    baseline: BaselineConfig
    refusals: int
    """Sentences of each kind that must be refused."""

    def settings(self, split: str) -> Settings:
        """What the file of a split is made from; without what nothing reads."""
        default = SPLITS[split]
        count = self.counts.get(split, default.count)
        return replace(default, count=count, seed=self.data_seed, final_image=False)

    def splits(self) -> list[str]:
        """All splits of which there are files."""
        names = [name for f in FAMILIES for name in (f.train, f.validation, *f.judged)]
        return list(dict.fromkeys(names))


def full_study(data_seed: int = 1) -> Study:
    """Three seeds, on about the amount of data that the paper has."""
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
    """One seed on a fifth of the data: shows that everything hangs together."""
    counts = dict.fromkeys(SPLITS, 40)
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
