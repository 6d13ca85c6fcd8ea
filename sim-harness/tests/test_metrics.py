"""Metrics on hand-made plans: right, partly right, refused."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pytest

from nsrm_harness.data.ground_truth import StepTruth
from nsrm_harness.domain.program import Step
from nsrm_harness.evaluation.metrics import (
    WRONG,
    Score,
    block_iou,
    box_iou,
    judge_plan,
    matched_ids,
    summarize,
)
from nsrm_harness.geometry.pose import Pose

EDGES = np.array([[0.04, 0.04, 0.04], [0.06, 0.06, 0.05]])


@dataclass(frozen=True)
class Planned:
    """Stands for `nsrm.PlannedStep`."""

    action: str = "MoveOn"
    object: tuple[str, ...] = ("red", "small")
    reference: tuple[str, ...] = ("blue",)
    object_id: int = 1
    reference_id: int = 2
    position: tuple[float, float, float] = (0.5, 0.1, 0.07)
    location: tuple[float, ...] = (0.1, 0.1, 0.2, 0.2, 1.0)


TRUTH = StepTruth(
    step=Step("MoveOn", ("small", "red"), ("blue",)),
    object_id=1,
    reference_id=2,
    end=41,
    sub_goal=Pose((0.5, 0.1, 0.07), (0.0, 0.0, 0.0, 1.0)),
    location=np.array([0.1, 0.1, 0.2, 0.2, 1.0], np.float32),
)


def test_the_same_plan_is_right_in_any_order_of_filters() -> None:
    score = judge_plan([Planned()], [TRUTH], EDGES)
    assert (score.program, score.object, score.reference) == (True, True, True)
    assert score.iou_2d == pytest.approx(1.0, abs=1e-6)
    assert score.iou_3d == pytest.approx(1.0)
    assert score.errors_m == (0.0,)


def test_a_wrong_object_gets_no_overlap() -> None:
    score = judge_plan([Planned(object_id=2)], [TRUTH], EDGES)
    assert score.program
    assert not score.object
    assert score.reference
    assert (score.iou_2d, score.iou_3d, score.errors_m) == (0.0, 0.0, ())


def test_a_missing_step_halves_the_plan() -> None:
    second = replace(TRUTH, object_id=2, reference_id=1)
    score = judge_plan([Planned()], [TRUTH, second], EDGES)
    assert not (score.program or score.object or score.reference)
    assert score.iou_2d == pytest.approx(0.5)


def test_a_detectors_ids_are_judged_as_the_objects_that_they_show() -> None:
    planned = Planned(object_id=7, reference_id=1)
    assert judge_plan([planned], [TRUTH], EDGES, {7: 1, 1: 2}) == judge_plan(
        [Planned()], [TRUTH], EDGES
    )
    # The same number is another object, and what shows no object is none.
    assert not judge_plan([Planned()], [TRUTH], EDGES, {1: 2, 2: 1}).object
    missed = judge_plan([planned], [TRUTH], EDGES, {1: 2})
    assert (missed.program, missed.object, missed.reference) == (True, False, True)
    assert (missed.iou_2d, missed.iou_3d, missed.errors_m) == (0.0, 0.0, ())


def test_boxes_found_get_the_ids_of_the_true_ones_that_they_show() -> None:
    true = np.array([[0.1, 0.1, 0.3, 0.3], [0.5, 0.5, 0.7, 0.7]], np.float32)
    found = np.stack([true[1] + 0.01, true[0] + 0.15, true[1]])
    assert matched_ids(found, true) == {3: 2}
    assert matched_ids(true[:0], true) == {}


def test_overlaps_by_hand() -> None:
    assert box_iou((0, 0, 2, 2), (1, 0, 3, 2)) == pytest.approx(1 / 3)
    assert box_iou((0, 0, 1, 1), (2, 2, 3, 3)) == 0.0
    assert block_iou((0, 0, 0), (0.02, 0, 0), (0.04, 0.05, 0.06)) == pytest.approx(1 / 3)
    assert block_iou((0, 0, 0), (0.05, 0, 0), (0.04, 0.05, 0.06)) == 0.0


def test_refusals_count_as_wrong() -> None:
    right = Score(True, True, True, 1.0, 1.0, (0.001, 0.003))
    refused = Score(False, False, False, 0.0, 0.0, ())
    metrics = summarize([right, refused], Counter({"ambiguous": 1}))
    assert (metrics.program, metrics.iou_2d) == (0.5, 0.5)
    assert metrics.error_median_m == pytest.approx(0.002)
    assert metrics.refused == {"ambiguous": 1}


def test_without_a_right_step_there_is_no_error_in_the_world() -> None:
    metrics = summarize([WRONG, WRONG], Counter({"ambiguous": 2}))
    assert (metrics.error_median_m, metrics.error_p95_m) == (None, None)
    assert json.loads(json.dumps(metrics.as_json(), allow_nan=False))["error_median_m"] is None
    assert "world error median -, p95 -; refused: ambiguous 2" in str(metrics)
