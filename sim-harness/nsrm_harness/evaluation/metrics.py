"""Computes the paper's metrics (section V-C), with plans from the core through the `nsrm` module.

The core gets only camera data: image, boxes, depths and calibration. The ground truth comes from
`data.ground_truth`. A refusal counts as wrong in every metric, and so does a scene that the
detector cannot use. A sequence is right only if each of its steps is right.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import nsrm
import numpy as np
from numpy.typing import ArrayLike, NDArray

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.number_text import or_dash
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth, StepTruth, Truth
from nsrm_harness.domain import FOUR_SIDES, Domain, load
from nsrm_harness.domain.dictionary import with_dictionary
from nsrm_harness.domain.everyday import with_everyday, without_states
from nsrm_harness.domain.program import Step, canonical
from nsrm_harness.evaluation.detector.match import match
from nsrm_harness.evaluation.observed import Boxes, chunks, objects_of, observe_episode
from nsrm_harness.perception.relief import PerceptionError

DEFAULT_DOMAIN = "tabletop"
"""The domain that everyday wording is written for."""


class EvaluationError(HarnessError):
    """A model that cannot be evaluated on a file."""


class StepPlan(Protocol):
    """The judged part of a planned step, which `nsrm.PlannedStep` has."""

    @property
    def action(self) -> str: ...
    @property
    def object(self) -> Sequence[str] | Mapping[str, object]: ...
    @property
    def reference(self) -> Sequence[str] | Mapping[str, object]: ...
    @property
    def object_id(self) -> int: ...
    @property
    def reference_id(self) -> int: ...
    @property
    def position(self) -> ArrayLike: ...
    @property
    def location(self) -> ArrayLike: ...


@dataclass(frozen=True)
class PlainStep:
    """A `StepPlan` that was not planned by the core."""

    object_id: int
    reference_id: int
    location: NDArray[np.float32]
    """Sub-goal in the image `[5]`."""
    position: NDArray[np.float64]
    """The same in the world `[3]`, metres."""
    action: str = ""
    object: tuple[str, ...] = ()
    reference: tuple[str, ...] = ()


@dataclass(frozen=True)
class Score:
    """The score of one plan against the ground truth; shares in 0..1."""

    program: bool
    """Whether actions and concepts of all steps are right, in any order of filters."""
    object: bool
    """Whether the moved object of each step is right (O1)."""
    reference: bool
    """Whether the reference of each step is right (O2)."""
    iou_2d: float
    """Plan accuracy by the boxes' intersection over union."""
    iou_3d: float
    """Plan accuracy by the blocks' intersection over union in the world."""
    errors_m: tuple[float, ...]
    """Distance from the true sub-goal of each step whose moved object is right."""


WRONG = Score(False, False, False, 0.0, 0.0, ())
"""The score of an episode without a plan."""


@dataclass(frozen=True)
class Metrics:
    """Means over the episodes of a file."""

    episodes: int
    program: float | None
    """None for a model without programs."""
    object: float
    reference: float
    iou_2d: float
    iou_3d: float
    error_median_m: float | None
    """Over all steps whose moved object is right; None, like p95, if there are none."""
    error_p95_m: float | None
    refused: dict[str, int]
    """Refusals by kind; "perception" means that the detector cannot use the image."""

    def as_json(self) -> dict[str, Any]:
        """The metrics for the model file and for `--json`."""
        return asdict(self)

    def __str__(self) -> str:
        refused = ", ".join(f"{kind} {count}" for kind, count in self.refused.items()) or "none"
        median, p95 = (
            or_dash(error_m, ".1f", times=1e3, unit=" mm")
            for error_m in (self.error_median_m, self.error_p95_m)
        )
        return (
            f"{self.episodes} episodes: program {or_dash(self.program, '.1%')}, "
            f"O1 {self.object:.1%}, O2 {self.reference:.1%}, IoU-2D {self.iou_2d:.1%}, "
            f"IoU-3D {self.iou_3d:.1%}, world error median {median}, p95 {p95}; "
            f"refused: {refused}"
        )


def load_model(path: Path | None) -> nsrm.Model:
    """Loads a model file, or the built-in model. Raises `EvaluationError`."""
    try:
        return nsrm.Model.load(path) if path else nsrm.Model.pretrained()
    except nsrm.ModelError as error:
        raise EvaluationError(str(error)) from error


@dataclass
class Pace:
    """The core's planning speed from crops, without observing and judging."""

    plans: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        rate = f", {self.plans / self.seconds:.0f} per second" if self.plans else ""
        return f"planned from crops: {self.plans}{rate}"


def evaluate(
    model: nsrm.Model,
    path: Path,
    boxes: Boxes = "mask",
    quiet: bool = False,
    pace: Pace | None = None,
) -> Metrics:
    """Plans every episode of a file and judges the plans; adds to `pace`."""
    return evaluate_models([model], path, boxes, quiet=quiet, pace=pace)[0]


def evaluate_models(
    models: Sequence[nsrm.Model],
    path: Path,
    boxes: Boxes = "mask",
    name: str = "evaluate",
    quiet: bool = False,
    pace: Pace | None = None,
) -> list[Metrics]:
    """Like `evaluate` for several models, observing every scene only once."""
    scores: list[list[Score]] = [[] for _ in models]
    refused: list[Counter[str]] = [Counter() for _ in models]
    for each in judge_episodes(models, path, boxes, name, quiet, pace):
        for own_scores, own_refused, judged in zip(scores, refused, each, strict=True):
            own_scores.append(judged.score)
            if judged.outcome is None:
                own_refused["perception"] += 1
            elif isinstance(judged.outcome, nsrm.Refused):
                own_refused[judged.outcome.kind] += 1
    return [summarize(*each) for each in zip(scores, refused, strict=True)]


@dataclass(frozen=True, eq=False)
class JudgedPlans:
    """A model's plan for an episode, and its score."""

    index: int
    truth: Truth
    outcome: nsrm.Plan | nsrm.Refused | None
    """None if the detector cannot use the image."""
    score: Score


def judge_episodes(
    models: Sequence[nsrm.Model],
    path: Path,
    boxes: Boxes = "mask",
    name: str = "evaluate",
    quiet: bool = False,
    pace: Pace | None = None,
) -> Iterator[list[JudgedPlans]]:
    """Plans each episode of a file with each model, in the order of the models."""
    with Demonstrations(path) as demonstrations, GroundTruth(path) as judge:
        for model in models:
            check_domain(model, demonstrations)
        for chunk in chunks(demonstrations, name, quiet):
            scenes = [_scene(demonstrations, judge, index, boxes) for index in chunk]
            seen = [scene for scene in scenes if scene.observed is not None]
            observed = [scene.observed for scene in seen if scene.observed is not None]
            sentences = [scene.sentence for scene in seen]
            began = time.perf_counter()
            plans = [iter(model.plan_all(observed, sentences)) for model in models]
            if pace is not None:
                pace.plans += len(models) * len(observed)
                pace.seconds += time.perf_counter() - began
            for scene in scenes:
                yield [_judged(scene, None if scene.observed is None else next(p)) for p in plans]


@dataclass(frozen=True, eq=False)
class _Scene:
    """An episode as observed by a model, and its ground truth."""

    index: int
    observed: nsrm.Observed | None
    """None if the detector cannot use the image."""
    sentence: str
    truth: Truth
    true_ids: dict[int, int] | None
    """See `judge_plan`."""


def _scene(demonstrations: Demonstrations, judge: GroundTruth, index: int, boxes: Boxes) -> _Scene:
    sentence, truth = demonstrations.sentences[index], judge.truth(index)
    try:
        objects = objects_of(demonstrations, index, boxes)
    except PerceptionError:
        return _Scene(index, None, sentence, truth, None)
    true_ids = None
    if boxes == "detector":
        own = objects_of(demonstrations, index, "mask")
        true_ids = matched_ids(objects.boxes, own.boxes)
    observed = observe_episode(demonstrations, index, objects)
    return _Scene(index, observed, sentence, truth, true_ids)


def _judged(scene: _Scene, outcome: nsrm.Plan | nsrm.Refused | None) -> JudgedPlans:
    score = WRONG
    if isinstance(outcome, nsrm.Plan):
        truth = scene.truth
        score = judge_plan(outcome.steps, truth.steps, truth.edges_m, scene.true_ids)
    return JudgedPlans(scene.index, scene.truth, outcome, score)


def check_domain(model: nsrm.Model, demonstrations: Demonstrations) -> None:
    """Raises `EvaluationError` if model and file have different domains."""
    domain = model.info()["domain"]
    if demonstrations.domain.name != domain:
        raise EvaluationError(
            f"{demonstrations.path}: has episodes of the domain {demonstrations.domain.name!r}, "
            f"but the model has {domain!r}"
        )


def domain_of(model: nsrm.Model, domain: Domain) -> Domain:
    """The domain of the episodes, with the model's actions if it has more of them, with everyday
    wording if it was taught that, and with relations in descriptions if it was taught those."""
    if domain.name != DEFAULT_DOMAIN:
        return domain
    info, every = model.info(), load(FOUR_SIDES)
    if [action.name for action in every.actions] == info["actions"]:
        domain = every
    everyday = with_dictionary(with_everyday(domain))
    if not everyday.other_words() <= set(info["words"]):
        return domain
    return everyday if info["relations"] else without_states(everyday)


def judge_plans(path: Path, plans: Sequence[Sequence[StepPlan]]) -> Metrics:
    """Judges one plan per episode of a file."""
    with GroundTruth(path) as judge:
        truths = [judge.truth(index) for index in range(len(judge))]
    scores = [
        judge_plan(steps, truth.steps, truth.edges_m)
        for steps, truth in zip(plans, truths, strict=True)
    ]
    return summarize(scores, Counter())


def matched_ids(found: NDArray[np.float32], true: NDArray[np.float32]) -> dict[int, int]:
    """Matches detections `[n, 4]` with true boxes `[m, 4]`: the true id of each matched one, where
    row i has id i + 1."""
    rows = enumerate(match(found, true))
    return {row + 1: int(own) + 1 for row, own in rows if own >= 0}


def judge_plan(
    steps: Sequence[StepPlan],
    truth: Sequence[StepTruth],
    edges_m: NDArray[np.float64],
    true_ids: Mapping[int, int] | None = None,
) -> Score:
    """Compares a plan with the ground truth.

    * `edges_m`: `[n, 3]` by object, id i + 1 in row i
    * `true_ids`: the true object of each of the plan's ids; a missing id is not a true object. None
      if the plan has the true ids
    """

    def right(planned_id: int, true_id: int) -> bool:
        return true_id == (planned_id if true_ids is None else true_ids.get(planned_id))

    same_length = len(steps) == len(truth)
    pairs = list(zip(steps, truth, strict=False))
    longest = max(len(steps), len(truth))
    overlaps, volumes, errors = 0.0, 0.0, []
    for planned, true in pairs:
        if not right(planned.object_id, true.object_id):
            continue
        overlaps += box_iou(planned.location, true.location)
        edges = edges_m[true.object_id - 1]
        volumes += block_iou(planned.position, true.sub_goal.position, edges)
        errors.append(float(np.linalg.norm(np.subtract(planned.position, true.sub_goal.position))))
    return Score(
        program=same_length and all(_same_program(planned, true) for planned, true in pairs),
        object=same_length and all(right(p.object_id, t.object_id) for p, t in pairs),
        reference=same_length and all(right(p.reference_id, t.reference_id) for p, t in pairs),
        iou_2d=overlaps / longest,
        iou_3d=volumes / longest,
        errors_m=tuple(errors),
    )


def summarize(scores: Sequence[Score], refused: Counter[str]) -> Metrics:
    """Means over episodes; errors over all steps whose moved object is right."""
    if not scores:
        raise EvaluationError("no episodes to evaluate")
    errors = [error for score in scores for error in score.errors_m]

    def mean(values: Iterable[float]) -> float:
        return float(np.mean(list(values)))

    return Metrics(
        episodes=len(scores),
        program=mean(score.program for score in scores),
        object=mean(score.object for score in scores),
        reference=mean(score.reference for score in scores),
        iou_2d=mean(score.iou_2d for score in scores),
        iou_3d=mean(score.iou_3d for score in scores),
        error_median_m=float(np.median(errors)) if errors else None,
        error_p95_m=float(np.quantile(errors, 0.95)) if errors else None,
        refused=dict(sorted((+refused).items())),
    )


def box_iou(left: ArrayLike, right: ArrayLike) -> float:
    """Intersection over union of two boxes x1, y1, x2, y2; further numbers are ignored."""
    a, b = np.asarray(left, np.float64)[:4], np.asarray(right, np.float64)[:4]
    shared = np.prod(np.maximum(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]), 0.0))
    areas = [np.prod(np.maximum(box[2:] - box[:2], 0.0)) for box in (a, b)]
    union = areas[0] + areas[1] - shared
    return float(shared / union) if union > 0.0 else 0.0


def block_iou(left: ArrayLike, right: ArrayLike, edges_m: ArrayLike) -> float:
    """Intersection over union of two axis-aligned blocks with the same edges, by their centres."""
    apart = np.abs(np.subtract(left, right))
    edges = np.asarray(edges_m, np.float64)
    shared = float(np.prod(np.maximum(edges - apart, 0.0)))
    return shared / (2.0 * float(np.prod(edges)) - shared)


def _same_program(planned: StepPlan, true: StepTruth) -> bool:
    understood = {name: getattr(planned, name) for name in ("action", "object", "reference")}
    return canonical([Step.from_json(understood)]) == canonical([true.step])
