"""Measures a plan's confidence: its calibration, and risk against coverage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Number of bins of the calibration error, of equal mass because confidences cluster near 1.
BINS = 15


@dataclass(frozen=True)
class Bin:
    """Plans of similar confidence."""

    #: Their share of all plans.
    mass: float
    #: Their mean confidence.
    confidence: float
    #: Share of right plans among them.
    right: float


def bins(
    confidences: ArrayLike, right: ArrayLike, weights: ArrayLike, count: int = BINS
) -> list[Bin]:
    """Puts plans into bins of about equal mass by confidence; empty bins are omitted.

    * `confidences`, `right`, `weights`: values for each plan
    """
    sure, correct = np.asarray(confidences, np.float64), np.asarray(right, np.float64)
    order = np.argsort(sure, kind="stable")
    sure, correct, mass = sure[order], correct[order], np.asarray(weights, np.float64)[order]
    mass = mass / mass.sum()
    number = ((np.cumsum(mass) - mass / 2) * count).astype(int)
    return [
        Bin(
            float(mass[own].sum()),
            float(np.average(sure[own], weights=mass[own])),
            float(np.average(correct[own], weights=mass[own])),
        )
        for own in (number == each for each in range(count))
        if own.any()
    ]


def calibration_error(parts: list[Bin]) -> float:
    """Expected calibration error: mean distance between confidence and accuracy; 0
    without plans."""
    return sum(part.mass * abs(part.confidence - part.right) for part in parts)


@dataclass(frozen=True, eq=False)
class Curve:
    """Coverage and risk for thresholds on the plan's confidence, from high to low."""

    #: Plans with at least this confidence are accepted.
    thresholds: NDArray[np.float64]
    #: Share of all sentences that are accepted.
    coverage: NDArray[np.float64]
    #: Share of accepted sentences that are wrong.
    risk: NDArray[np.float64]

    def at(self, threshold: float) -> tuple[float, float]:
        """Coverage and risk at a threshold; the risk is 0 if nothing is accepted."""
        accepted = int(np.searchsorted(-self.thresholds, -threshold, side="right"))
        if accepted == 0:
            return 0.0, 0.0
        return float(self.coverage[accepted - 1]), float(self.risk[accepted - 1])


def risk_curve(confidences: ArrayLike, right: ArrayLike, weights: ArrayLike) -> Curve:
    """Risk against coverage for a falling threshold.

    * `confidences`: confidence of each sentence's plan; NaN if refused
    * `right`: whether each plan is right
    * `weights`: weight of each sentence
    """
    sure, weight = np.asarray(confidences, np.float64), np.asarray(weights, np.float64)
    wrong = weight * ~np.asarray(right, bool)
    planned = np.flatnonzero(~np.isnan(sure))
    order = planned[np.argsort(-sure[planned], kind="stable")]
    thresholds = sure[order]
    # Plans with the same confidence are accepted or rejected together.
    last = np.flatnonzero(np.diff(thresholds, append=-np.inf))
    accepted = np.cumsum(weight[order])[last]
    return Curve(
        thresholds[last], accepted / weight.sum(), np.cumsum(wrong[order])[last] / accepted
    )
