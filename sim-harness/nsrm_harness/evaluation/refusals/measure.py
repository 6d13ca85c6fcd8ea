"""Measures refusals through the core: of sentences that must be refused, and of good ones.

A sentence that must be refused counts as refused whatever the reason. The plan of a good sentence
is right if its program and the objects of all its steps are right.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import nsrm
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import EpisodeFileError
from nsrm_harness.common.number_text import or_dash
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth, Truth
from nsrm_harness.evaluation.metrics import EvaluationError, check_domain, domain_of, judge_plan
from nsrm_harness.evaluation.observed import chunks, objects_of, observe_episode
from nsrm_harness.evaluation.refusals.certainty import (
    Bin,
    Curve,
    bins,
    calibration_error,
    risk_curve,
)
from nsrm_harness.evaluation.refusals.sentences import COUNT, SETS, Item, make_items
from nsrm_harness.evaluation.refusals.spoiler import KINDS, Situation

COLUMNS = ("kind", "set", "count", "refused", "wrongly_accepted")
THRESHOLDS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999)
"""Thresholds on a plan's confidence for which coverage and risk are reported."""
EXAMPLES = 5
"""Number of wrongly accepted sentences that are reported per kind, most confident first."""
GOOD = "good"
"""The kind of the file's own sentences."""


@dataclass(frozen=True)
class SentenceResult:
    """The result for one sentence."""

    kind: str
    scene: int
    sentence: str
    #: Kind of the refusal; None if accepted.
    refusal: str | None
    #: Confidence of the plan; None if there is no plan.
    confidence: float | None = None
    #: The program that was understood; empty if refused.
    program: str = ""
    #: Whether it is a good sentence and was planned correctly.
    right: bool = False
    #: The word that the refusal suggests.
    suggestion: str | None = None


@dataclass(frozen=True)
class KindCount:
    """Number of refused sentences of a kind."""

    kind: str
    set: str
    count: int
    refused: int
    wrongly_accepted: int
    #: Numbers by kind of refusal.
    reasons: dict[str, int]
    #: The most confident of the accepted ones.
    examples: tuple[SentenceResult, ...]


@dataclass(frozen=True, eq=False)
class RefusalReport:
    """What a model refuses, and what it accepts."""

    set: str
    kinds: tuple[KindCount, ...]
    #: The file's own sentences: how many, how many planned correctly, and refusals by kind.
    good: int
    right: int
    refused: dict[str, int]
    #: Share of misspelt words for which the right word was suggested; None without such words.
    suggested: float | None
    #: Over good and bad sentences, both with the same total weight.
    curve: Curve
    #: For the plans of good sentences, and for all plans with the same weights.
    good_bins: list[Bin]
    mixed_bins: list[Bin]

    def as_json(self) -> dict[str, Any]:
        """The report for `--json`."""
        points = {str(threshold): self.curve.at(threshold) for threshold in THRESHOLDS}
        return {
            "set": self.set,
            "kinds": [asdict(kind) for kind in self.kinds],
            "good": {"count": self.good, "right": self.right, "refused": self.refused},
            "suggested": self.suggested,
            "calibration_error": {
                "bins": f"{len(self.good_bins)} of equal mass",
                "good": calibration_error(self.good_bins),
                "mixed": calibration_error(self.mixed_bins),
            },
            "thresholds": {
                threshold: {"coverage": coverage, "risk": risk}
                for threshold, (coverage, risk) in points.items()
            },
        }

    def __str__(self) -> str:
        lines = [f"{'kind':<28}{'set':<12}{'count':>6}{'refused':>9}{'accepted':>10}"]
        for kind in self.kinds:
            lines.append(
                f"{kind.kind:<28}{kind.set:<12}{kind.count:>6}{kind.refused:>9}"
                f"{kind.wrongly_accepted:>10}"
            )
            lines += [
                f"    {or_dash(each.confidence, '.4f')}  {each.sentence}" for each in kind.examples
            ]
        reasons = ", ".join(f"{kind} {count}" for kind, count in self.refused.items()) or "none"
        lines += [
            f"good sentences: {self.good}, {self.right} planned correctly, refused: {reasons}",
            f"misspelt words with the right suggestion: {or_dash(self.suggested, '.1%')}",
            f"calibration error, {len(self.good_bins)} bins of equal mass: plans for good "
            f"sentences {calibration_error(self.good_bins):.4f}, all plans "
            f"{calibration_error(self.mixed_bins):.4f}",
        ]
        for threshold in THRESHOLDS:
            coverage, risk = self.curve.at(threshold)
            lines.append(
                f"confidence at least {threshold}: coverage {coverage:.3f}, risk {risk:.4f}"
            )
        return "\n".join(lines)

    def write_csv(self, path: Path) -> None:
        """Writes one row per kind of bad sentence, with `COLUMNS`."""
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS)
            writer.writerows([getattr(kind, name) for name in COLUMNS] for kind in self.kinds)


def measure(
    model: nsrm.Model, path: Path, which: str, count: int = COUNT, quiet: bool = False
) -> RefusalReport:
    """Plans the sentences of a file, and those that must be refused in its scenes."""
    with Demonstrations(path) as demonstrations:
        _check(model, demonstrations, which)
    items = near_misses(model, path, count)
    meant: dict[str, str | None] = {item.sentence: item.meant for item in items}
    return report(plan_sentences(model, path, items, quiet), which, meant)


def near_misses(model: nsrm.Model, path: Path, count: int = COUNT) -> list[Item]:
    """Sentences that the model must refuse in the scenes of a file, `count` of each kind; none if
    its split is not one of `SETS`."""
    with Demonstrations(path) as demonstrations, GroundTruth(path) as judge:
        which, domain = demonstrations.split, domain_of(model, demonstrations.domain)
        if which not in SETS:
            return []
        truths = [judge.truth(index) for index in range(len(judge))]
    return make_items(domain, situations(truths), which, count)


def plan_sentences(
    model: nsrm.Model, path: Path, items: Sequence[Item] = (), quiet: bool = False
) -> list[SentenceResult]:
    """Plans the sentences of a file, and others in its scenes that must be refused."""
    by_scene: dict[int, list[Item]] = {}
    for item in items:
        by_scene.setdefault(item.scene, []).append(item)
    outcomes: list[SentenceResult] = []
    with Demonstrations(path) as demonstrations, GroundTruth(path) as judge:
        check_domain(model, demonstrations)
        for chunk in chunks(demonstrations, "refusals", quiet):
            planned: list[Item] = []
            observed: list[nsrm.Observed] = []
            for index in chunk:
                good = Item(index, demonstrations.sentences[index], GOOD)
                own = [good, *by_scene.get(index, [])]
                objects = objects_of(demonstrations, index, "mask")
                planned += own
                observed += [observe_episode(demonstrations, index, objects)] * len(own)
            plans = model.plan_all(observed, [item.sentence for item in planned])
            outcomes += [
                outcome_of(item, plan, judge.truth(item.scene) if item.kind == GOOD else None)
                for item, plan in zip(planned, plans, strict=True)
            ]
    return outcomes


def situations(truths: Sequence[Truth]) -> list[Situation]:
    """The situations from which sentences are made, by episode."""
    return [Situation(index, truth.attributes, truth.program) for index, truth in enumerate(truths)]


def outcome_of(item: Item, plan: nsrm.Plan | nsrm.Refused, truth: Truth | None) -> SentenceResult:
    """The result for a sentence; `truth`: its meaning, if it has one."""
    if isinstance(plan, nsrm.Refused):
        return SentenceResult(
            item.kind, item.scene, item.sentence, plan.kind, suggestion=plan.suggestion
        )
    right = False
    if truth is not None:
        score = judge_plan(plan.steps, truth.steps, truth.edges_m)
        right = score.program and score.object and score.reference
    return SentenceResult(
        item.kind, item.scene, item.sentence, None, plan.confidence, plan.program.notation, right
    )


def report(
    outcomes: Sequence[SentenceResult], which: str, meant: dict[str, str | None]
) -> RefusalReport:
    """Counts refusals by kind and evaluates confidences; `meant`: misspelt words by sentence."""
    good = [each for each in outcomes if each.kind == GOOD]
    bad = [each for each in outcomes if each.kind != GOOD]
    if not good or not bad:
        raise EvaluationError("no sentences to plan")
    weights = np.array([1 / len(good if each.kind == GOOD else bad) for each in outcomes])
    is_good = np.array([each.kind == GOOD for each in outcomes])
    # NaN if there is no plan.
    confidences = np.array([each.confidence for each in outcomes], np.float64)
    right = np.array([each.right for each in outcomes])
    planned = ~np.isnan(confidences)

    def bins_of(chosen: NDArray[np.bool_]) -> list[Bin]:
        return bins(confidences[chosen], right[chosen], weights[chosen])

    misspelt = [each for each in bad if meant.get(each.sentence)]
    offered = [each.suggestion == meant[each.sentence] for each in misspelt]
    return RefusalReport(
        set=which,
        kinds=tuple(_count(kind, which, bad) for kind in KINDS),
        good=len(good),
        right=sum(each.right for each in good),
        refused=_reasons(good),
        suggested=float(np.mean(offered)) if offered else None,
        curve=risk_curve(confidences, right, weights),
        good_bins=bins_of(planned & is_good),
        mixed_bins=bins_of(planned),
    )


def _count(kind: str, which: str, outcomes: Sequence[SentenceResult]) -> KindCount:
    own = [each for each in outcomes if each.kind == kind]
    accepted = [each for each in own if each.refusal is None]
    accepted.sort(key=lambda each: -(each.confidence or 0.0))
    return KindCount(
        kind,
        which,
        len(own),
        len(own) - len(accepted),
        len(accepted),
        _reasons(own),
        tuple(accepted[:EXAMPLES]),
    )


def _reasons(outcomes: Sequence[SentenceResult]) -> dict[str, int]:
    counts = Counter(each.refusal for each in outcomes if each.refusal is not None)
    return dict(sorted(counts.items()))


def _check(model: nsrm.Model, demonstrations: Demonstrations, which: str) -> None:
    check_domain(model, demonstrations)
    if demonstrations.split != which:
        raise EpisodeFileError(
            f"{demonstrations.path}: has the split {demonstrations.split!r}, but the set {which!r} "
            "takes its scenes from the split with its name"
        )
