"""Judges models on files of episodes in separate processes, and caches the results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import nsrm

from nsrm_harness.evaluation.metrics import evaluate_models
from nsrm_harness.evaluation.observed import Boxes
from nsrm_harness.paper.tables.cache import make_all
from nsrm_harness.paper.tables.results import ResultRow


class Contender(NamedTuple):
    """A model file and its name in the rows."""

    name: str
    seed: int
    path: Path


class Judging(NamedTuple):
    """A task: models to judge on one file."""

    split: str
    data: Path
    contenders: tuple[Contender, ...]
    boxes: Boxes | None
    """None for baselines, which get the mask's boxes."""

    @property
    def name(self) -> str:
        """Name of the file with its rows."""
        return f"{self.split}-{self.boxes or 'baseline'}"

    def figures(self) -> list[dict[str, Any]]:
        """The rows as JSON."""
        return [asdict(row) for row in self.rows()]

    def rows(self) -> list[ResultRow]:
        """One row per model."""
        if self.boxes is None:
            # Imported here: JAX takes seconds in each process, and the core does not need it.
            from nsrm_harness.learning.baseline.evaluate import evaluate_baseline
            from nsrm_harness.learning.baseline.file import read_baseline

            metrics = [
                evaluate_baseline(read_baseline(each.path).model, self.data)
                for each in self.contenders
            ]
        else:
            models = [nsrm.Model.load(each.path) for each in self.contenders]
            metrics = evaluate_models(models, self.data, self.boxes, self.name)
        return [
            ResultRow.of(self.split, each.name, each.seed, self.boxes or "mask", found)
            for each, found in zip(self.contenders, metrics, strict=True)
        ]


def judge_all(
    judgings: Sequence[Judging], folder: Path, jobs: int, title: str
) -> list[list[ResultRow]]:
    """The rows of each task; those cached in `folder` are not computed again.

    Raises `TaskError`; earlier results stay cached.
    """
    made = make_all({judging.name: judging for judging in judgings}, folder, jobs, title)
    return [[ResultRow(**row) for row in rows] for rows in made]
