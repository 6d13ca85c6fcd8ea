"""A miniature training from nothing, by the commands that a researcher types.

A full run takes 2,500 episodes; this one takes a few minutes and shows that episodes,
every stage of training, calibration, export and evaluation through the core hang together,
and that something is learned.
"""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
COUNTS = {"train": 300, "validation": 60, "test": 60}
#: Share of test sentences whose whole program must be right. 43 % were when this was
#: written; a model that learned nothing gets none of the hundreds of possible programs.
LEAST_PROGRAM = 0.1


def cargo(*arguments: str) -> str:
    """Runs cargo in the root of the checkout; what it printed."""
    ran = subprocess.run(
        ["cargo", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert ran.returncode == 0, f"cargo {' '.join(arguments)}:\n{ran.stdout}\n{ran.stderr}"
    return ran.stdout


@dataclass(frozen=True)
class Run:
    """Where the data and the results of the training are."""

    data: Path
    out: Path

    @property
    def model(self) -> str:
        """Path of the model file."""
        return str(self.out / "model.safetensors")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    data = tmp_path_factory.mktemp("data")
    for split, count in COUNTS.items():
        out = str(data / f"{split}.h5")
        cargo("harness", "episodes", "--split", split, "--count", str(count), "--out", out)
    cargo("harness", "calibration", "--count", "60", "--out", str(data / "calibration.h5"))
    out = tmp_path_factory.mktemp("run")
    cargo("harness", "train", "--quick", "--data", str(data), "--out", str(out))
    return Run(data, out)


def test_the_model_file_is_valid_and_says_how_it_was_made(run: Run) -> None:
    cargo("run", "--quiet", "--package", "nsrm", "--", "check", run.model)
    info = cargo("run", "--quiet", "--package", "nsrm", "--", "info", "--json", run.model)
    training = json.loads(info)["training"]
    assert training["episodes"] == COUNTS["train"]
    assert len(training["data_hash"]) == 64


def test_something_is_learned_as_the_core_sees_it(run: Run) -> None:
    test = str(run.data / "test.h5")
    printed = cargo("harness", "evaluate", "--json", "--model", run.model, "--data", test)
    metrics = json.loads(printed)
    assert metrics["episodes"] == COUNTS["test"]
    assert metrics["program"] >= LEAST_PROGRAM, metrics


def test_the_curves_are_drawn(run: Run) -> None:
    colors = Image.open(run.out / "curves.png").convert("RGB").getcolors(1 << 24)
    assert colors is not None and len(colors) > 10
