"""What a model loses with rounded weights."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import nsrm
import pytest
from harness_command import run

from nsrm_harness import domain as domains
from nsrm_harness.common.marked_text import MarkError
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.evaluation.metrics import EvaluationError
from nsrm_harness.evaluation.quantised import (
    BEGIN,
    END,
    QuantisedRow,
    pairs,
    read_rows,
    with_table,
    write_rows,
)

ROWS = [
    QuantisedRow("test", "f32", 2000, 99.85, 99.9, 99.9, 95.0, 93.25, 0.05),
    QuantisedRow("test", "int8", 2000, 99.75, 99.8, 99.8, 94.5, 93.09, 0.0),
    QuantisedRow("near misses", "f32", 4000, 0.0, None, None, None, None, 0.7),
    QuantisedRow("near misses", "int8", 4000, 0.0, None, None, None, None, 0.75),
]


def test_a_model_is_the_same_but_for_its_weights() -> None:
    trained, rounded = nsrm.Model.pretrained(), nsrm.Model.pretrained(precision="int8")
    before, after = trained.info(), rounded.info()
    assert (before["precision"], after["precision"]) == ("f32", "int8")
    assert before["identity"] == after["identity"]
    weights = [sum(array["bytes"] for array in each["flash"]["arrays"]) for each in (before, after)]
    assert weights[1] < 0.4 * weights[0]
    sentence = "put the small red block on the leftmost blue one, then put white left of green"
    assert str(trained.parse(sentence)) == str(rounded.parse(sentence))
    with pytest.raises(nsrm.NsrmError, match=r'expected f32 or int8, got "int4"'):
        nsrm.Model.pretrained("int4")  # pyright: ignore[reportArgumentType]


def test_a_model_file_can_be_loaded_in_either_precision() -> None:
    path = Path(__file__).parents[2] / "weights-codegen/tabletop/tabletop.safetensors"
    loaded = nsrm.Model.load(path, precision="int8").info()
    assert loaded["precision"] == "int8"
    assert loaded["identity"] == nsrm.Model.pretrained("int8").info()["identity"]


def test_rows_come_back_from_their_file(tmp_path: Path) -> None:
    path = tmp_path / "quantised.csv"
    write_rows(path, ROWS)
    assert read_rows(path) == ROWS
    assert [(trained.split, rounded.wrongly_obeyed) for trained, rounded in pairs(ROWS)] == [
        ("test", 0.0),
        ("near misses", 0.75),
    ]
    path.write_text("split,precision\ntest,f32\n", encoding="utf-8")
    with pytest.raises(EvaluationError, match="not the rows of 'harness quantised'"):
        read_rows(path)


def test_a_page_has_both_precisions_side_by_side() -> None:
    page = with_table(f"before\n{BEGIN}\nold\n{END}\nbehind\n", ROWS)
    assert "| test | 2000 | 99.85 | 99.75 | 93.25 | 93.09 | 0.05 | 0.00 |" in page
    assert "| near misses | 4000 | 0.00 | 0.00 |  |  | 0.70 | 0.75 |" in page
    assert page.startswith("before\n") and page.endswith("behind\n") and "old" not in page
    assert with_table(page, ROWS) == page
    with pytest.raises(MarkError, match="the page lacks a mark"):
        with_table("no marks", ROWS)


@pytest.mark.slow
def test_the_command_judges_both_on_the_same_episodes(tmp_path: Path) -> None:
    settings = replace(
        SPLITS["test"], count=6, seed=3, steps=(1, 1), final_image=False, renderer="pybullet"
    )
    data, out, page = (tmp_path / name for name in ("one.h5", "quantised.csv", "page.md"))
    assert generate(settings, domains.load(domains.FOUR_SIDES), data)
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    options = ("--near-misses", 50, "--out", out, "--page", page)
    assert run("quantised", "--data", data, *options) == 0
    rows = read_rows(out)
    assert [(row.split, row.precision, row.count) for row in rows] == [
        ("one", "f32", 6),
        ("one", "int8", 6),
        ("near misses", "f32", 50),
        ("near misses", "int8", 50),
    ]
    assert all(row.program >= 80.0 for row in rows[:2])
    assert with_table(page.read_text(encoding="utf-8"), rows) == page.read_text(encoding="utf-8")
