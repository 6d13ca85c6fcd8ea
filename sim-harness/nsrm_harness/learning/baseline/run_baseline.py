"""Runs the baseline: trains, fits the camera map, evaluates, and writes the file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import jax

from nsrm_harness.data.calibration import Calibration
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.evaluation.metrics import Metrics
from nsrm_harness.learning import calibrate
from nsrm_harness.learning.baseline.evaluate import evaluate_baseline
from nsrm_harness.learning.baseline.file import BaselineFile, write_baseline
from nsrm_harness.learning.baseline.train import BaselineConfig, train
from nsrm_harness.learning.baseline.words import StepWords, read_ends, vocabulary
from nsrm_harness.learning.dataset import training_set
from nsrm_harness.learning.run_training import Files


def run(
    files: Files,
    config: BaselineConfig,
    seed: int,
    out: Path,
    say: Callable[[str], None] = print,
) -> Metrics:
    """Writes `baseline.safetensors` to `out`; returns the metrics on test.

    If interrupted, it leaves nothing behind: the file is written once, at the end.
    """
    camera = calibrate.fit_camera(Calibration.load(files.calibration))
    with Demonstrations(files.train) as demonstrations:
        domain, data = demonstrations.domain, training_set(demonstrations)
        words = StepWords.of(vocabulary(domain), demonstrations.sentences, read_ends(files.train))
    model = calibrate.with_camera(train(vocabulary(domain), data, words, config, seed), camera)
    metrics = evaluate_baseline(model, files.test)
    path = out / "baseline.safetensors"
    training = {
        "seed": seed,
        "episodes": len(data),
        "data_hash": data.hash(),
        "config": asdict(config),
        "jax": jax.__version__,
    }
    write_baseline(path, BaselineFile(model, domain, training, metrics.as_json()))
    say(str(metrics))
    say(f"baseline: {path}")
    return metrics
