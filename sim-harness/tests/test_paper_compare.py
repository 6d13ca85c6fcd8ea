"""A model judged without the core gets the same result as through it."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import nsrm
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.evaluation.metrics import evaluate
from nsrm_harness.learning.export import read_model
from nsrm_harness.paper.tables.compare import judge_without_core

MODEL = Path(__file__).resolve().parents[2] / "weights-codegen/tabletop/tabletop.safetensors"


@pytest.mark.slow
def test_without_the_core_the_figures_are_the_same(tmp_path: Path) -> None:
    path = tmp_path / "test.h5"
    settings = replace(SPLITS["test"], count=30, seed=9)
    generate(settings, domains.load(), path, LocalProcesses(os.cpu_count() or 1))
    through = evaluate(nsrm.Model.load(MODEL), path, quiet=True)
    without = judge_without_core(read_model(MODEL), path)
    # What the core refuses as unsure is planned without it.
    assert sum(through.refused.values()) <= 1
    for name in ("program", "object", "reference", "iou_2d", "iou_3d"):
        assert getattr(without, name) == pytest.approx(getattr(through, name), abs=0.035), name
    if not through.refused:
        assert without.program == through.program
        assert without.iou_3d == pytest.approx(through.iou_3d, abs=1e-3)
        assert without.error_median_m == pytest.approx(through.error_median_m, abs=1e-5)
