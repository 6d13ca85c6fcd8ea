"""The paper's figures (Tables III to VI), in percent."""

from __future__ import annotations

from typing import NamedTuple


class PaperRow(NamedTuple):
    """A row of one of the paper's tables; the baseline has no programs."""

    program: float | None
    o1: float
    o2: float
    iou_2d: float
    iou_3d: float


TABLES = {
    "train": "III, train",
    "test": "III, test",
    "novel_pairs": "IV, novel attribute pairs",
    "steps_3": "V, three steps",
    "multi_attribute": "VI, two attributes",
}
"""The table of each split that is in the paper."""

ROWS = {
    ("train", "nsrm"): PaperRow(99.1, 98.0, 97.8, 59.8, 29.1),
    ("train", "baseline"): PaperRow(None, 95.7, 98.0, 54.0, 33.3),
    ("test", "nsrm"): PaperRow(97.3, 95.8, 96.2, 52.6, 25.5),
    ("test", "baseline"): PaperRow(None, 90.2, 93.0, 30.3, 14.7),
    ("novel_pairs", "nsrm"): PaperRow(98.5, 96.3, 96.3, 51.6, 25.2),
    ("novel_pairs", "baseline"): PaperRow(None, 87.5, 89.1, 29.0, 16.6),
    ("steps_3", "nsrm"): PaperRow(56.8, 54.7, 53.6, 27.2, 12.9),
    ("steps_3", "baseline"): PaperRow(None, 76.0, 80.9, 13.3, 6.6),
    ("multi_attribute", "nsrm"): PaperRow(98.0, 75.7, 89.5, 27.3, 9.3),
    ("multi_attribute", "baseline"): PaperRow(None, 55.0, 32.4, 3.2, 1.5),
}
