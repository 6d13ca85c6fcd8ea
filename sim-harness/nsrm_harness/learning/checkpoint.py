"""Saves the state of a training run in its folder, so that it can be resumed after Ctrl-C."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import equinox as eqx

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.whole_file import write_whole


class CheckpointError(HarnessError):
    """A checkpoint that belongs to another run."""


@dataclass
class TrainingProgress:
    """The progress of a run."""

    stage: int = 0
    """Index of the current stage."""
    epoch: int = 0
    """Finished epochs in it."""
    attempt: int = 0
    """How often training was restarted because actions had merged."""
    losses: dict[str, list[float]] = field(default_factory=dict)
    """Mean loss of each epoch, by stage."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Time spent, by stage."""


class Checkpoints:
    """Reads and writes the checkpoint of one run, atomically."""

    def __init__(self, folder: Path, run: str):
        """`run` identifies everything that the result depends on."""
        self._folder = folder
        self._index = folder / "checkpoint.json"
        self._run = hashlib.sha256(run.encode()).hexdigest()

    def save(self, progress: TrainingProgress, state: Any) -> None:
        """Writes the arrays under a new name, then makes the index point to them."""
        self._folder.mkdir(parents=True, exist_ok=True)
        name = f"checkpoint-{progress.stage}-{progress.epoch}.eqx"
        eqx.tree_serialise_leaves(self._folder / name, state)
        content = {"run": self._run, "state": name, "progress": asdict(progress)}
        write_whole(self._index, json_text(content).encode())
        for old in self._folder.glob("checkpoint-*.eqx"):
            if old.name != name:
                old.unlink()

    def progress(self) -> TrainingProgress | None:
        """The progress of the run; None if there is no checkpoint."""
        if not self._index.exists():
            return None
        content = json.loads(self._index.read_text(encoding="utf-8"))
        if content["run"] != self._run:
            raise CheckpointError(
                f"{self._index}: from a run with other data, seed or configuration; "
                "use another --out, or start again without --resume"
            )
        return TrainingProgress(**content["progress"])

    def begin(self, progress: TrainingProgress, model: Any) -> None:
        """Saves the model at the start of a stage."""
        self._folder.mkdir(parents=True, exist_ok=True)
        eqx.tree_serialise_leaves(self._begun(progress), model)

    def begun(self, progress: TrainingProgress, like: Any) -> Any:
        """The model at the start of the stage, in the structure of `like`."""
        if not self._begun(progress).exists():
            raise CheckpointError(
                f"{self._begun(progress)}: missing, so the run cannot resume: start again without "
                "--resume"
            )
        return eqx.tree_deserialise_leaves(self._begun(progress), like)

    def _begun(self, progress: TrainingProgress) -> Path:
        return self._folder / f"begun-{progress.attempt}-{progress.stage}.eqx"

    def state(self, like: Any) -> Any:
        """The arrays of the checkpoint in the structure of `like`."""
        content = json.loads(self._index.read_text(encoding="utf-8"))
        return eqx.tree_deserialise_leaves(self._folder / content["state"], like)
