"""Models judged in separate processes: the same results as in one process, and only once."""

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
from nsrm_harness.paper.tables.judging import Contender, Judging, judge_all
from nsrm_harness.paper.tables.processes import TaskError
from nsrm_harness.paper.tables.results import ResultRow

MODEL = Path(__file__).resolve().parents[2] / "weights-codegen/tabletop/tabletop.safetensors"
CONTENDERS = (Contender("nsrm", 0, MODEL), Contender("other", 3, MODEL))


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("episodes") / "test.h5"
    settings = replace(SPLITS["test"], count=6, seed=9)
    generate(settings, domains.load(), path, LocalProcesses(os.cpu_count() or 1))
    return path


def test_rows_are_those_of_one_process_and_are_kept(episodes: Path, tmp_path: Path) -> None:
    judgings = [
        Judging("test", episodes, CONTENDERS, "mask"),
        Judging("test", episodes, CONTENDERS[:1], "detector"),
    ]
    found = judge_all(judgings, tmp_path / "figures", 2, "judging")
    model = nsrm.Model.load(MODEL)
    assert found == [
        [
            ResultRow.of("test", each.name, each.seed, judging.boxes or "", metrics)
            for metrics in [evaluate(model, episodes, judging.boxes or "mask", quiet=True)]
            for each in judging.contenders
        ]
        for judging in judgings
    ]
    # What is there is not judged again: it could not be.
    gone = [judging._replace(data=tmp_path / "gone.h5") for judging in judgings]
    assert judge_all(gone, tmp_path / "figures", 2, "judging") == found


def test_a_file_that_can_not_be_judged_is_told_and_the_others_are_kept(
    episodes: Path, tmp_path: Path
) -> None:
    judgings = [
        Judging("test", episodes, CONTENDERS, "mask"),
        Judging("gone", tmp_path / "gone.h5", CONTENDERS, "mask"),
    ]
    with pytest.raises(TaskError, match=r"gone-mask: failed: .*gone\.h5.* \(more in .*\.log\)"):
        judge_all(judgings, tmp_path, 1, "judging")
    assert sorted(path.name for path in tmp_path.glob("*.json")) == ["test-mask.json"]
