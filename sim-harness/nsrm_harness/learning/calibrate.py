"""Fits what is not trained: the camera map, the certainty of actions, and the thresholds for
refusals.

None of this uses the ground truth of an episode: the map comes from calibration scenes with known
poses, the certainty and the thresholds from the sentences and scenes of the validation data.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.calibration import Calibration
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.learning import decode
from nsrm_harness.learning.dataset import TrainingSet
from nsrm_harness.learning.export import Thresholds
from nsrm_harness.learning.model import MATCH_SCORE, Model, Network

SCORES = np.linspace(-1.0, 1.0, 2001)
"""Candidates for the smallest score of a match."""
PLATEAU = 0.002
"""Shares of references that differ by less than this count as equal."""
QUANTILE = 0.001
"""Share of validation confidences that may be below the decision threshold."""
DECISION_RANGE = (0.5, 0.8)
"""Range of the decision threshold. Below one half the alternatives together are more likely; above
0.8 the quantile shows only that validation had no hard case."""
SCALES = (0.5, 4.0)
"""Range of the factor on the actions' logits."""
HALVINGS = 30
LEAST_ROWS = 100
ROUNDS = 5
OUTLIER = 3.0
"""A block whose error exceeds the median by this factor is excluded from the next round: it is
partly hidden, so its visible box and depth do not show where it is."""


class CalibrationError(HarnessError):
    """Data that cannot be used for fitting."""


@dataclass(frozen=True)
class CameraFit:
    """A fitted camera map, and its errors on the data of the fit."""

    weight: np.ndarray
    """`[3, 6]`: from (X, Y, D, W, H, 1) to the centre in the camera's frame."""
    median_m: float
    p95_m: float
    used: float
    """Share of blocks that were used."""


def terms(locations: Any, camera: Camera, numpy: ModuleType = np) -> Any:
    """Locations `[..., 5]` -> (X, Y, D, W, H, 1) `[..., 6]`: the box deprojected at its mean depth.

    `numpy`: NumPy, with doubles, or a module like it for its arrays
    """
    locations = np.asarray(locations, np.float64) if numpy is np else locations
    x1, y1, x2, y2, depth = numpy.moveaxis(locations, -1, 0)
    x = ((x1 + x2) / 2 * camera.width - camera.cx) / camera.fx * depth
    y = ((y1 + y2) / 2 * camera.height - camera.cy) / camera.fy * depth
    width = (x2 - x1) * camera.width / camera.fx * depth
    height = (y2 - y1) * camera.height / camera.fy * depth
    return numpy.stack([x, y, depth, width, height, numpy.ones_like(depth)], axis=-1)


def fit_camera(calibration: Calibration) -> CameraFit:
    """Least-squares fit to blocks at known poses, repeated without partly hidden ones."""
    count = len(calibration.locations)
    if count < LEAST_ROWS:
        raise CalibrationError(
            f"the calibration file has {count} blocks, at least {LEAST_ROWS} are needed: "
            "generate more with 'harness calibration'"
        )
    inputs = np.concatenate(
        [
            terms(location[None], camera)
            for location, camera in zip(calibration.locations, calibration.cameras, strict=True)
        ]
    )
    targets = np.concatenate(
        [
            camera.to_camera(position[None])
            for position, camera in zip(calibration.positions, calibration.cameras, strict=True)
        ]
    )
    used = np.ones(count, bool)
    for _ in range(ROUNDS):
        weight = np.linalg.lstsq(inputs[used], targets[used], rcond=None)[0].T
        errors = np.linalg.norm(inputs @ weight.T - targets, axis=1)
        used = errors < OUTLIER * np.median(errors)
    return CameraFit(
        weight,
        float(np.median(errors)),
        float(np.quantile(errors, 0.95)),
        float(np.mean(used)),
    )


def with_camera(model: Network, fit: CameraFit) -> Network:
    """The model with the fitted map."""
    return eqx.tree_at(lambda m: m.camera.weight, model, jnp.asarray(fit.weight, jnp.float32))


@dataclass(frozen=True)
class CertaintyFit:
    """The correction of the parser's certainty of actions."""

    scale: float
    """Factor on the actions' logits."""
    right: float
    """Share of one-step commands whose action explains the final scene best, with a pseudocount of
    one right and one wrong command."""
    before: float
    """Mean probability of their actions before the correction."""


def fit_certainty(model: Model, data: TrainingSet) -> CertaintyFit:
    """Fits the certainty to the commands and scenes of validation data.

    Trained also on nonsense and inserted words, the parser is less sure than it is right. Scaling
    the logits keeps the actions and makes their mean probability right.
    """
    return certainty_of(*decode.weigh_actions(model, data, decode.see_all(model, data)))


def certainty_of(logits: np.ndarray, best: np.ndarray) -> CertaintyFit:
    """The same for the logits `[N, A]` of one-step commands and the actions that explain them."""
    if len(best) == 0:
        raise CalibrationError("the validation data has no one-step commands")
    right = (np.sum(logits.argmax(axis=1) == best) + 1) / (len(best) + 2)
    return CertaintyFit(sharpness(logits, right), float(right), _certainty(logits, 1.0))


def sharpness(logits: np.ndarray, right: float) -> float:
    """The factor on logits `[N, A]`, within `SCALES`, that makes the mean of their largest
    probabilities equal to `right`."""
    low, high = SCALES
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if _certainty(logits, middle) < right else (low, middle)
    return (low + high) / 2


def _certainty(logits: np.ndarray, scale: float) -> float:
    scaled = scale * (logits.astype(np.float64) - logits.max(axis=1, keepdims=True))
    return float(np.mean(1.0 / np.exp(scaled).sum(axis=1)))


def with_certainty(model: Model, fit: CertaintyFit) -> Model:
    """The model with scaled action logits."""
    decoder = model.language.action_decoder
    assert decoder.bias is not None, "the decoder is made with a bias"
    return eqx.tree_at(
        lambda m: (m.language.action_decoder.weight, m.language.action_decoder.bias),
        model,
        (fit.scale * decoder.weight, fit.scale * decoder.bias),
    )


@dataclass(frozen=True)
class ThresholdFit:
    """Fitted thresholds, and the figures behind them."""

    thresholds: Thresholds
    plateau: tuple[float, float]
    """Range of scores over which the share hardly changes."""
    share: float
    """Share of references with exactly one match there."""
    lowest_confidence: float
    """The quantile of confidences, before it was limited."""


def fit_thresholds(model: Model, data: TrainingSet) -> ThresholdFit:
    """Fits the thresholds to the initial scenes and sentences of validation data.

    The match score is the one that training considers as likely as not, if it lies on the plateau;
    otherwise the middle of the plateau.
    """
    shares = unique_shares(reference_scores(model, data), data)
    low, high = widest_plateau(SCORES, shares)
    confidences = decode.confidences(model, data)
    quantile = float(np.quantile(confidences, QUANTILE))
    decision = float(np.clip(quantile, *DECISION_RANGE))
    score = score_within(low, high)
    share = float(shares[np.searchsorted(SCORES, score)])
    return ThresholdFit(Thresholds(score, decision), (low, high), share, quantile)


def score_within(low: float, high: float) -> float:
    """The match score for a plateau; see `fit_thresholds`."""
    return MATCH_SCORE if low <= MATCH_SCORE <= high else (low + high) / 2


def reference_scores(model: Model, data: TrainingSet) -> np.ndarray:
    """Filtered score of each object for each group of each sentence, `[N, G, M]`; NaN for none."""
    similarities = decode.see_all(model, data)
    groups = data.sentences.groups
    scores = np.full((*groups.shape[:2], data.present.shape[1]), np.nan)
    for episode, count in enumerate(data.sentences.group_count):
        for number in range(count):
            concepts = groups[episode, number]
            chosen = similarities[episode][:, concepts[concepts >= 0]].min(axis=1)
            scores[episode, number] = np.where(data.present[episode], chosen, np.nan)
    return scores


def unique_shares(scores: np.ndarray, data: TrainingSet) -> np.ndarray:
    """Share of references with exactly one match, for each of `SCORES`."""
    references = scores[np.arange(scores.shape[1]) < data.sentences.group_count[:, None]]
    # Exactly one matches if the threshold lies between the second best and the best.
    ordered = np.sort(np.nan_to_num(references, nan=-np.inf), axis=-1)
    best, second = ordered[:, -1], ordered[:, -2]
    return np.array([np.mean((second < score) & (score <= best)) for score in SCORES])


def widest_plateau(scores: np.ndarray, shares: np.ndarray) -> tuple[float, float]:
    """The longest run of scores whose shares are within `PLATEAU` of the maximum."""
    if shares.max() == 0.0:
        raise CalibrationError(
            "no threshold gives any reference of the validation data a unique match"
        )
    is_high = shares >= shares.max() - PLATEAU
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_high.astype(int), [0]])))
    starts, ends = edges[::2], edges[1::2] - 1
    longest = int(np.argmax(ends - starts))
    return float(scores[starts[longest]]), float(scores[ends[longest]])
