"""Finds a model's least confidence on validation sentences, and counts on other sets what is
accepted there."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import nsrm
import numpy as np
from matplotlib import pyplot as plt

from nsrm_harness.common.number_text import or_dash
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.evaluation.metrics import EvaluationError, load_model
from nsrm_harness.evaluation.refusals.measure import (
    GOOD,
    SentenceResult,
    near_misses,
    plan_sentences,
)

#: Bounds below this share are drawn there.
LEAST_SHARE = 1e-5


class ThresholdError(EvaluationError):
    """Validation sentences that guarantee the limit at no confidence."""


@dataclass(frozen=True)
class RiskLimit:
    """What is to be guaranteed."""

    wrong: float
    """Greatest share of wrong plans among the accepted ones."""
    level: float
    """Probability with which it is kept."""


@dataclass(frozen=True)
class SetRow:
    """What is accepted of a set of sentences at the confidence that was found."""

    set: str
    sentences: int
    accepted: int
    wrong: int
    bound: float | None
    """Greatest share of wrong ones that agrees with these numbers, at the limit's level; None for
    sentences of which none should be accepted."""


@dataclass(frozen=True)
class CalibrationReport:
    """The confidence that was found, and what it accepts."""

    limit: RiskLimit
    found: nsrm.Accepted
    thresholds: tuple[nsrm.Accepted, ...]
    """What is accepted of the validation sentences at each threshold."""
    rows: tuple[SetRow, ...]

    def as_json(self) -> dict[str, Any]:
        """The report for `--json`."""
        return {
            "limit": asdict(self.limit),
            "confidence": self.found.threshold,
            "thresholds": [
                {
                    "confidence": each.threshold,
                    "accepted": each.count,
                    "wrong": each.wrong,
                    "bound": each.bound,
                }
                for each in self.thresholds
            ],
            "sets": [asdict(row) for row in self.rows],
        }

    def __str__(self) -> str:
        lines = [f"{'set':<24}{'sentences':>10}{'accepted':>10}{'wrong':>7}{'at most':>11}"]
        lines += [
            f"{row.set:<24}{row.sentences:>10}{row.accepted:>10}{row.wrong:>7}"
            f"{or_dash(row.bound, '.3%'):>11}"
            for row in self.rows
        ]
        lines.append(
            f"least confidence {self.found.threshold:.4g}: of the accepted commands, at most "
            f"{100 * self.limit.wrong:.4g} % are wrong, with a probability of "
            f"{100 * self.limit.level:.4g} %"
        )
        return "\n".join(lines)

    def write_csv(self, path: Path) -> None:
        """Writes one row per set."""
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, SetRow.__dataclass_fields__, lineterminator="\n")
            writer.writeheader()
            writer.writerows(asdict(row) for row in self.rows)


def load_uncalibrated(path: Path | None) -> nsrm.Model:
    """A model file, or the built-in model, that accepts a plan of any confidence: what an earlier
    calibration would refuse has to be judged, too."""
    if path is None:
        return load_model(None)
    try:
        content = nsrm.with_confidence(path.read_bytes(), 0.0)
    except (OSError, nsrm.ModelError) as error:
        raise EvaluationError(f"{path}: {error}") from error
    with TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_bytes(content)
        return load_model(copy)


def calibrate(
    model: nsrm.Model,
    validation: Path,
    others: Sequence[Path],
    limit: RiskLimit,
    count: int,
    quiet: bool = False,
) -> CalibrationReport:
    """Finds the least confidence on the sentences of a file, and on those that must be refused in
    its scenes; the sentences of the other files are then judged with it.

    * `validation`: file with the split `validation`
    * `others`: files with other splits, of which `test` has sentences that must be refused, too
    * `count`: how many of these there are of each kind

    Raises `ThresholdError` if that guarantees the limit at no confidence.
    """
    outcomes = _planned(model, validation, count, quiet)
    confidences, right = _arrays(outcomes)
    try:
        found = nsrm.least_confidence(confidences, right, limit.wrong, limit.level)
    except nsrm.NsrmError as error:
        raise ThresholdError(f"{validation}: {error}") from error
    rows = _rows(_split_of(validation), outcomes, found, limit)
    for path in others:
        rows += _rows(_split_of(path), _planned(model, path, count, quiet), found, limit)
    thresholds = nsrm.accepted(confidences, right, limit.level)
    return CalibrationReport(limit, found, tuple(thresholds), tuple(rows))


def draw_calibration(report: CalibrationReport, path: Path) -> None:
    """Draws, for each threshold on the confidence, the accepted share and the bound on the wrong
    one."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
    names = [f"{each.threshold:.4g}" for each in report.thresholds]
    places = np.arange(len(names))
    left.bar(places, [each.count for each in report.thresholds], color="tab:blue")
    left.set(title="accepted validation sentences", ylabel="count")
    shares = [each.wrong / max(each.count, 1) for each in report.thresholds]
    right.plot(
        places, [each.bound for each in report.thresholds], "o-", color="tab:red", label="at most"
    )
    right.plot(
        places, np.maximum(shares, LEAST_SHARE), "o", mfc="none", color="tab:red", label="counted"
    )
    right.axhline(report.limit.wrong, color="0.4", linestyle=":", label="limit")
    right.set(title="wrong among the accepted", ylabel="share", yscale="log")
    right.set_ylim(LEAST_SHARE, 1.0)
    right.legend()
    for axis in (left, right):
        axis.axvline(
            names.index(f"{report.found.threshold:.4g}"), color="tab:green", alpha=0.3, linewidth=8
        )
        axis.set_xticks(places, names, rotation=45)
        axis.set_xlabel("least confidence (green: the one that was found)")
        axis.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _split_of(path: Path) -> str:
    with Demonstrations(path) as demonstrations:
        return demonstrations.split


def _planned(model: nsrm.Model, path: Path, count: int, quiet: bool) -> list[SentenceResult]:
    return plan_sentences(model, path, near_misses(model, path, count), quiet)


def _rows(
    split: str, outcomes: Sequence[SentenceResult], found: nsrm.Accepted, limit: RiskLimit
) -> list[SetRow]:
    """One row for the good sentences, one for those that must be refused."""
    rows = []
    for name, good in ((split, True), (f"{split}, near misses", False)):
        own = [each for each in outcomes if (each.kind == GOOD) == good]
        if not own:
            continue
        at = next(
            each
            for each in nsrm.accepted(*_arrays(own), limit.level)
            if each.threshold == found.threshold
        )
        rows.append(SetRow(name, len(own), at.count, at.wrong, at.bound if good else None))
    return rows


def _arrays(outcomes: Sequence[SentenceResult]) -> tuple[np.ndarray, np.ndarray]:
    # NaN if there is no plan.
    confidences = np.array([each.confidence for each in outcomes], np.float32)
    return confidences, np.array([each.right for each in outcomes], bool)
