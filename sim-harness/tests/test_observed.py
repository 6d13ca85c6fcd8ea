"""Evaluation with the detector's boxes instead of the mask's."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import h5py
import nsrm
import numpy as np
import pytest
from harness_command import run

from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.evaluation.metrics import evaluate
from nsrm_harness.evaluation.observed import objects_of

COUNT = 6


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("episodes") / "test.h5"
    make = ("--split", "test", "--count", str(COUNT), "--jobs", "1", "--renderer", "pybullet")
    assert run("episodes", *make, "--out", path) == 0
    return path


@pytest.fixture
def copied(episodes: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(episodes, tmp_path / "copied.h5"))


@pytest.fixture(scope="module")
def model() -> nsrm.Model:
    return nsrm.Model.pretrained()


@pytest.mark.slow
def test_the_detectors_boxes_lead_to_the_same_objects(episodes: Path, model: nsrm.Model) -> None:
    mask = evaluate(model, episodes, quiet=True)
    detector = evaluate(model, episodes, "detector", quiet=True)
    assert mask.object == 1.0
    for name in ("episodes", "program", "object", "reference", "refused"):
        assert getattr(detector, name) == getattr(mask, name)
    # The boxes are others: nothing of the mask is seen.
    assert detector.iou_2d != mask.iou_2d
    assert detector.iou_2d == pytest.approx(mask.iou_2d, abs=0.03)
    assert detector.error_median_m == pytest.approx(mask.error_median_m, abs=0.001)


def test_a_moved_block_that_is_missed_counts_as_wrong(
    episodes: Path, copied: Path, model: nsrm.Model
) -> None:
    with GroundTruth(copied) as judge:
        moved = judge.truth(0).steps[0].object_id - 1
    with h5py.File(copied, "r+") as file:
        depths = file["initial/depth"]
        assert isinstance(depths, h5py.Dataset)
        box = file["initial/boxes"][0, moved] * (640, 480, 640, 480)  # type: ignore[index]
        left, top, right, bottom = np.rint(box).astype(int)
        depths[0, top:bottom, left:right] = 0
    with Demonstrations(copied) as demonstrations:
        found = objects_of(demonstrations, 0, "detector")
        assert len(found.boxes) == demonstrations.object_count[0] - 1
    metrics = evaluate(model, copied, "detector", quiet=True)
    assert metrics.object == pytest.approx(1 - 1 / COUNT)
    assert evaluate(model, copied, quiet=True) == evaluate(model, episodes, quiet=True)


def test_a_picture_without_a_table_counts_as_wrong(copied: Path, model: nsrm.Model) -> None:
    with h5py.File(copied, "r+") as file:
        file["initial/depth"][2] = np.zeros((480, 640), np.uint16)  # type: ignore[index]
    metrics = evaluate(model, copied, "detector", quiet=True)
    assert metrics.episodes == COUNT
    assert metrics.refused == {"perception": 1}
    assert metrics.program == metrics.object == pytest.approx(1 - 1 / COUNT)


def test_the_command_takes_either(episodes: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("evaluate", "--data", episodes, "--boxes", "detector", "--json") == 0
    assert json.loads(capsys.readouterr().out)["episodes"] == COUNT
    assert run("evaluate", "--data", episodes, "--boxes", "eyes") == 2
    assert "'eyes' is not one of 'mask', 'detector'" in capsys.readouterr().err
