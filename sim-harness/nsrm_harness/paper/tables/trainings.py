"""Trains models and baselines, on this machine or on one to which the data is sent."""

from __future__ import annotations

import os
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import jax

from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.whole_file import write_whole
from nsrm_harness.learning.baseline.run_baseline import run as run_baseline
from nsrm_harness.learning.baseline.train import BaselineConfig
from nsrm_harness.learning.config import TrainingConfig
from nsrm_harness.learning.run_training import Files, finish, fit

DONE = "trained.json"
"""File with the metrics on test, in the folder of a finished training."""
KEPT = ("model.safetensors", "baseline.safetensors", "curves.png", DONE)
"""Files that a remote training sends back."""


class Training(NamedTuple):
    """The training of a model or a baseline."""

    files: Files
    config: TrainingConfig | BaselineConfig
    seed: int
    out: Path

    @property
    def is_done(self) -> bool:
        """Whether it is finished."""
        return (self.out / DONE).exists()


def train(training: Training) -> None:
    """Trains on this machine, resuming if interrupted."""
    files, config, seed, out = training
    keep_compiled(out)
    if isinstance(config, TrainingConfig):
        metrics = finish(fit(files, config, seed, out, resume=True), files.test, out)
    else:
        metrics = run_baseline(files, config, seed, out)
    write_whole(out / DONE, json_text(metrics.as_json()).encode())


def packed(training: Training) -> tuple[dict[str, bytes], Any, int]:
    """The arguments of `train_elsewhere`."""
    contents = {
        field.name: getattr(training.files, field.name).read_bytes() for field in fields(Files)
    }
    return contents, training.config, training.seed


def train_elsewhere(
    contents: dict[str, bytes], config: TrainingConfig | BaselineConfig, seed: int
) -> dict[str, bytes]:
    """Trains on files with these contents; returns the contents of the results by name."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        for key, content in contents.items():
            (folder / f"{key}.h5").write_bytes(content)
        train(Training(Files.of(folder), config, seed, folder / "run"))
        made = (folder / "run" / name for name in KEPT)
        return {path.name: path.read_bytes() for path in made if path.exists()}


def unpack(made: dict[str, bytes], out: Path) -> None:
    """Writes what `train_elsewhere` returned; the file that marks it as done comes last."""
    for name in sorted(made, key=lambda name: name == DONE):
        write_whole(out / name, made[name])


def keep_compiled(out: Path) -> None:
    """Caches what XLA compiles next to a training's folder, for the other trainings there, unless
    the environment names another place."""
    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    jax.config.update("jax_compilation_cache_dir", str(out.parent / "compiled"))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.5)
