"""How far a plan's confidence can be believed: calibration, and risk against coverage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Bins of the calibration error, of equal mass: confidences crowd near 1.
BINS = 15


@dataclass(frozen=True)
class Bin:
    """Plans of about the same confidence."""

    #: Their share of all.
    mass: float
    #: Their mean confidence.
    confidence: float
    #: Share of them that is right.
    right: float


def bins(
    confidences: ArrayLike, right: ArrayLike, weights: ArrayLike, count: int = BINS
) -> list[Bin]:
    """Plans by confidence in bins of about equal mass; those that would be empty are left out.

    * `confidences`, `right`, `weights`: of each plan
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
    """Expected calibration error: mean distance of confidence and share right; 0 without plans."""
    return sum(part.mass * abs(part.confidence - part.right) for part in parts)


@dataclass(frozen=True, eq=False)
class Curve:
    """What would come of a threshold on the plan's confidence, from high to low."""

    #: Plans of at least this confidence are accepted.
    thresholds: NDArray[np.float64]
    #: Share of all sentences that is accepted.
    coverage: NDArray[np.float64]
    #: Share of what is accepted that is wrong.
    risk: NDArray[np.float64]

    def at(self, threshold: float) -> tuple[float, float]:
        """Coverage and risk at a threshold; nothing accepted has no risk."""
        accepted = int(np.searchsorted(-self.thresholds, -threshold, side="right"))
        if accepted == 0:
            return 0.0, 0.0
        return float(self.coverage[accepted - 1]), float(self.risk[accepted - 1])


def risk_curve(confidences: ArrayLike, right: ArrayLike, weights: ArrayLike) -> Curve:
    """Risk against coverage as the threshold falls.

    * `confidences`: of each sentence's plan; NaN where it is refused
    * `right`: whether the plan is
    * `weights`: of each sentence
    """
    sure, weight = np.asarray(confidences, np.float64), np.asarray(weights, np.float64)
    wrong = weight * ~np.asarray(right, bool)
    planned = np.flatnonzero(~np.isnan(sure))
    order = planned[np.argsort(-sure[planned], kind="stable")]
    thresholds = sure[order]
    # Of plans with the same confidence all are accepted or none.
    last = np.flatnonzero(np.diff(thresholds, append=-np.inf))
    accepted = np.cumsum(weight[order])[last]
    return Curve(
        thresholds[last], accepted / weight.sum(), np.cumsum(wrong[order])[last] / accepted
    )
