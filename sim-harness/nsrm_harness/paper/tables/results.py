"""The figures of the tables, and their CSV file."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from statistics import fmean
from typing import Any

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.whole_file import write_whole
from nsrm_harness.evaluation.metrics import Metrics

MEASURES = ("program", "o1", "o2", "iou_2d", "iou_3d")
DECIMALS = 2


class ResultsError(HarnessError):
    """A file of figures that cannot be read."""


@dataclass(frozen=True)
class ResultRow:
    """The results of a model of one seed on one split, in percent."""

    split: str
    model: str
    """`nsrm` or `baseline`."""
    seed: int
    boxes: str
    """`mask` or `detector`."""
    episodes: int
    program: float | None
    """None for the baseline, which has no programs."""
    o1: float
    o2: float
    iou_2d: float
    iou_3d: float

    @classmethod
    def of(cls, split: str, model: str, seed: int, boxes: str, metrics: Metrics) -> ResultRow:
        """Converts metrics, which are shares, to percentages."""
        shares = (
            metrics.program,
            metrics.object,
            metrics.reference,
            metrics.iou_2d,
            metrics.iou_3d,
        )
        program, *rest = (None if s is None else round(100 * s, DECIMALS) for s in shares)
        o1, o2, iou_2d, iou_3d = (value or 0.0 for value in rest)
        return cls(split, model, seed, boxes, metrics.episodes, program, o1, o2, iou_2d, iou_3d)


COLUMNS = tuple(field.name for field in fields(ResultRow))


@dataclass(frozen=True)
class Summary:
    """A measure over the seeds."""

    mean: float
    least: float
    greatest: float


def summarize(rows: Sequence[ResultRow], measure: str) -> Summary | None:
    """Summarises a measure over the rows; None if a row lacks it or there are no rows."""
    values = [getattr(row, measure) for row in rows]
    if not values or None in values:
        return None
    return Summary(fmean(values), min(values), max(values))


def select(rows: Iterable[ResultRow], split: str, model: str, boxes: str) -> list[ResultRow]:
    """The rows of all seeds for a split, model and kind of boxes."""
    wanted = (split, model, boxes)
    return [row for row in rows if (row.split, row.model, row.boxes) == wanted]


def write_rows(path: Path, rows: Sequence[ResultRow]) -> None:
    """Writes rows as CSV with `COLUMNS`; the baseline's program is empty."""
    write_records(path, COLUMNS, rows)


def write_records(path: Path, columns: Sequence[str], records: Sequence[object]) -> None:
    """Writes a CSV file of these fields; None is left empty."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([getattr(record, name) for name in columns] for record in records)


def read_rows(path: Path) -> list[ResultRow]:
    """Reads rows written by `write_rows`."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.reader(file)
            header = tuple(next(reader, ()))
            if header != COLUMNS:
                raise ResultsError(f"{path}: expected the columns {','.join(COLUMNS)}")
            return [_row(values) for values in reader]
    except (OSError, ValueError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: cannot read the figures: {error}") from error


def write_json(path: Path, content: Any) -> None:
    """Writes a file atomically."""
    write_whole(path, json_text(content, indent=1).encode())


def _row(values: Sequence[str]) -> ResultRow:
    split, model, seed, boxes, episodes, program, *rest = values
    o1, o2, iou_2d, iou_3d = map(float, rest)
    share = float(program) if program else None
    return ResultRow(split, model, int(seed), boxes, int(episodes), share, o1, o2, iou_2d, iou_3d)
