"""Computes the paper's metrics of the baseline, except for the program, which it lacks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.data.file import Demonstrations
from nsrm_harness.evaluation.metrics import EvaluationError, Metrics, PlainStep, judge_plans
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.learning.baseline.model import Baseline, Meaning, carry_out
from nsrm_harness.learning.baseline.train import understand
from nsrm_harness.learning.baseline.words import StepWords, read_ends, vocabulary
from nsrm_harness.learning.dataset import TrainingSet, training_set
from nsrm_harness.learning.reference import locate


def evaluate_baseline(model: Baseline, path: Path, quiet: bool = False) -> Metrics:
    """Plans every episode of a file, split at the true ends of steps, and judges the plans."""
    with Demonstrations(path) as demonstrations:
        if vocabulary(demonstrations.domain) != model.words:
            raise EvaluationError(f"{path}: its domain has other words than the baseline's")
        data = training_set(demonstrations, quiet)
        words = StepWords.of(model.words, demonstrations.sentences, read_ends(path))
        cameras = [demonstrations.camera(index) for index in range(len(demonstrations))]
    return replace(judge_plans(path, plans(model, data, words, cameras)), program=None)


def plans(
    model: Baseline, data: TrainingSet, words: StepWords, cameras: list[Camera]
) -> list[list[PlainStep]]:
    """The steps of each command of the data."""
    meaning = understand(model, data, words)
    goals = np.asarray(_goals(model, meaning, jnp.asarray(data.before), jnp.asarray(words.count)))
    moved, references = (np.argmax(a, axis=-1) for a in (meaning.object, meaning.reference))
    return [
        [
            PlainStep(
                int(moved[index, step]) + 1,
                int(references[index, step]) + 1,
                goals[index, step],
                locate(model.camera, goals[index, step], cameras[index]),
            )
            for step in range(count)
        ]
        for index, count in enumerate(words.count)
    ]


@eqx.filter_jit
def _goals(model: Baseline, meaning: Meaning, before: Array, count: Array) -> Array:
    def one(meaning: Meaning, before: Array, count: Array) -> Array:
        return carry_out(model.simulator, meaning, before, count, hard=True)[1]

    return jax.vmap(one)(meaning, before, count)
