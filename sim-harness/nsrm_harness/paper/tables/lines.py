"""Markdown rows of the report's tables, and the titles of splits and measures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nsrm_harness.common.number_text import or_dash
from nsrm_harness.paper.tables.results import MEASURES, ResultRow, summarize

HEADINGS = ("program", "O1", "O2", "IoU-2D", "IoU-3D")
TITLES = {
    "train": "training episodes, 1-2 steps",
    "test": "test, 1-2 steps",
    "novel_pairs": "attribute pairs not in the training data",
    "steps_3": "3 steps, trained on 1-2",
    "steps_4": "4 steps",
    "steps_5": "5 steps",
    "steps_6": "6 steps",
    "steps_8": "8 steps",
    "multi_attribute": "two attributes in each description, trained on one",
    "objects_8": "8 objects, trained on 4-6",
    "objects_10": "10 objects, trained on 4-6",
    "paraphrase": "word orders not in the training data",
}


def cells_of(rows: Sequence[ResultRow]) -> list[str]:
    """Each measure of a model's rows: the mean over the seeds, with the lowest and highest."""
    cells = []
    for measure in MEASURES:
        summary = summarize(rows, measure)
        if summary is None:
            cells.append("-")
        elif len(rows) == 1:
            cells.append(number(summary.mean))
        else:
            cells.append(f"{summary.mean:.1f} ({summary.least:.1f}-{summary.greatest:.1f})")
    return cells


def number(value: float | None) -> str:
    """A percentage, or a dash for None."""
    return or_dash(value, ".1f")


def header_of(first: str) -> str:
    """The first two lines of a table of all measures."""
    return line_of(first, HEADINGS) + "\n|---|" + "---:|" * len(HEADINGS)


def line_of(first: str, cells: Iterable[str]) -> str:
    """A row of a table."""
    return f"| {first} | " + " | ".join(cells) + " |"
