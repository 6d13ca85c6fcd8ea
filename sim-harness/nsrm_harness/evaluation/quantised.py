"""What a model loses with rounded weights: both are judged on the same episodes and sentences."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Final, Literal, get_args

import nsrm

from nsrm_harness.common.marked_text import replaced
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation import language
from nsrm_harness.evaluation.metrics import EvaluationError, judge_episodes, summarize
from nsrm_harness.evaluation.relations import measure_relations

Precision = Literal["f32", "int8"]
BEGIN: Final = "<!-- precisions: `cargo harness quantised` replaces them -->"
END: Final = "<!-- end of precisions -->"
PRECISIONS: Final[tuple[Precision, ...]] = get_args(Precision)


@dataclass(frozen=True)
class QuantisedRow:
    """What a model of one precision reaches on one set; percentages."""

    split: str
    precision: str
    count: int
    """Episodes or sentences."""
    program: float
    """Understood as meant."""
    o1: float | None
    """None, as the three below, for sentences without a scene."""
    o2: float | None
    iou_2d: float | None
    iou_3d: float | None
    wrongly_obeyed: float
    """Understood as something else, and not refused."""

    def __str__(self) -> str:
        placed = "" if self.iou_3d is None else f", IoU-3D {self.iou_3d:.2f} %"
        return (
            f"{self.split}, {self.precision}: {self.count}, program {self.program:.2f} %{placed}, "
            f"wrongly obeyed {self.wrongly_obeyed:.2f} %"
        )


def load(path: Path | None) -> dict[Precision, nsrm.Model]:
    """A model, or the built-in one, in each precision. Raises `EvaluationError`."""
    try:
        return {
            each: nsrm.Model.load(path, each) if path else nsrm.Model.pretrained(each)
            for each in PRECISIONS
        }
    except nsrm.ModelError as error:
        raise EvaluationError(str(error)) from error


def on_episodes(models: dict[Precision, nsrm.Model], path: Path) -> Iterator[QuantisedRow]:
    """Judges plans by the paper's metrics."""
    judged = list(judge_episodes(list(models.values()), path, name=path.stem))
    for number, precision in enumerate(models):
        own = [each[number] for each in judged]
        metrics = summarize([each.score for each in own], Counter())
        wrong = sum(isinstance(each.outcome, nsrm.Plan) and not each.score.program for each in own)
        assert metrics.program is not None
        shares = (metrics.object, metrics.reference, metrics.iou_2d, metrics.iou_3d)
        o1, o2, iou_2d, iou_3d = (100 * share for share in shares)
        program, wrongly = 100 * metrics.program, 100 * wrong / max(len(own), 1)
        yield QuantisedRow(path.stem, precision, len(own), program, o1, o2, iou_2d, iou_3d, wrongly)


def on_sentences(
    models: dict[Precision, nsrm.Model],
    measure: Callable[[nsrm.Model], Sequence[language.Counted]],
) -> Iterator[QuantisedRow]:
    """Counts understood and refused sentences, as `measure` does."""
    for precision, model in models.items():
        for row in measure(model):
            share = 100 / max(row.count, 1)
            right, wrong = share * row.right, share * row.wrong
            yield QuantisedRow(row.set, precision, row.count, right, None, None, None, None, wrong)


def measure_all(
    models: dict[Precision, nsrm.Model],
    domain: Domain,
    episodes: Sequence[Path],
    relations: Sequence[Path],
    lists: Sequence[Path],
    near_misses: int,
    seed: int,
) -> Iterator[QuantisedRow]:
    """All rows: of files of episodes, then of the sets of `harness language`."""
    for path in episodes:
        yield from on_episodes(models, path)
    for path in relations:
        yield from on_sentences(
            models, lambda model, path=path: measure_relations(model, path, seed)
        )
    yield from on_sentences(
        models, lambda model: [language.measure_near_misses(model, domain, near_misses, seed)]
    )
    for path in lists:
        yield from on_sentences(
            models, lambda model, path=path: language.measure_list(model, path, domain, seed)
        )


COLUMNS: Final = tuple(field.name for field in fields(QuantisedRow))


def write_rows(path: Path, rows: Sequence[QuantisedRow]) -> None:
    """Writes a row per set and precision, as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            values = astuple(row)
            writer.writerow(
                f"{value:.2f}" if isinstance(value, float) else value for value in values
            )


def read_rows(path: Path) -> list[QuantisedRow]:
    """Reads what `write_rows` has written; raises `EvaluationError`."""

    def share(text: str) -> float | None:
        return float(text) if text else None

    try:
        with path.open(encoding="utf-8", newline="") as file:
            return [
                QuantisedRow(
                    split=row["split"],
                    precision=row["precision"],
                    count=int(row["count"]),
                    program=float(row["program"]),
                    o1=share(row["o1"]),
                    o2=share(row["o2"]),
                    iou_2d=share(row["iou_2d"]),
                    iou_3d=share(row["iou_3d"]),
                    wrongly_obeyed=float(row["wrongly_obeyed"]),
                )
                for row in csv.DictReader(file)
            ]
    except (OSError, UnicodeDecodeError, KeyError, ValueError, TypeError) as error:
        raise EvaluationError(
            f"{path}: not the rows of 'harness quantised': {error}: write them anew"
        ) from error


def pairs(rows: Sequence[QuantisedRow]) -> list[tuple[QuantisedRow, QuantisedRow]]:
    """Of each set the row as trained, and the rounded one."""
    rounded = {row.split: row for row in rows if row.precision == "int8"}
    return [(row, rounded[row.split]) for row in rows if row.precision == "f32"]


def with_table(page: str, rows: Sequence[QuantisedRow]) -> str:
    """A page with the table between its marks replaced. Raises `MarkError`."""
    head = "| set | count | program: f32 | int8 | IoU-3D: f32 | int8 | wrongly obeyed: f32 | int8 |"
    lines = [head, "|---|---:|---:|---:|---:|---:|---:|---:|"]
    for trained, rounded in pairs(rows):
        both = (
            (trained.program, rounded.program),
            (trained.iou_3d, rounded.iou_3d),
            (trained.wrongly_obeyed, rounded.wrongly_obeyed),
        )
        cells = ["" if share is None else f"{share:.2f}" for pair in both for share in pair]
        lines.append(f"| {trained.split} | {trained.count} | {' | '.join(cells)} |")
    return replaced(page, BEGIN, "\n".join(lines), END)
