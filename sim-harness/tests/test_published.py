"""What is told of the project's figures is what the committed report has."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import pytest

from nsrm_harness.tables import paper
from nsrm_harness.tables.publish import MODEL, README, REPORT_FOLDER, with_figures
from nsrm_harness.tables.report import REPORT, TABLES, tables_of
from nsrm_harness.tables.results import read_rows

ROOT = Path(__file__).resolve().parents[2]
REPORT_PATH = ROOT / REPORT_FOLDER


def test_the_readmes_figures_are_the_reports() -> None:
    readme = (ROOT / README).read_text(encoding="utf-8")
    assert with_figures(readme, REPORT_PATH) == readme, "run 'cargo harness publish'"


def test_the_reports_text_has_the_figures_of_its_tables() -> None:
    text = (REPORT_PATH / REPORT).read_text(encoding="utf-8")
    tables = tables_of(read_rows(REPORT_PATH / TABLES))
    assert len(tables) == len(paper.TABLES) + 2
    for table in tables:
        assert table in text


def test_the_committed_model_is_the_one_that_was_judged() -> None:
    content = (ROOT / MODEL).read_bytes()
    (size,) = struct.unpack("<Q", content[:8])
    metadata = json.loads(content[8 : 8 + size])["__metadata__"]
    metrics, seed = json.loads(metadata["metrics"]), json.loads(metadata["training"])["seed"]
    (row,) = (
        row
        for row in read_rows(REPORT_PATH / TABLES)
        if (row.split, row.model, row.boxes, row.seed) == ("test", "nsrm", "mask", seed)
    )
    assert row.episodes == metrics["episodes"]
    for own, told in (
        (row.program, "program"),
        (row.o1, "object"),
        (row.o2, "reference"),
        (row.iou_2d, "iou_2d"),
        (row.iou_3d, "iou_3d"),
    ):
        assert own == pytest.approx(100 * metrics[told], abs=0.006)
