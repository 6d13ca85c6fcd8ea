"""Camera map and thresholds on synthetic data with a known answer."""

from __future__ import annotations

import numpy as np
import pytest

from nsrm_harness.data.calibration import Calibration
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.learning.calibrate import (
    SCORES,
    CalibrationError,
    fit_camera,
    score_within,
    sharpness,
    terms,
    widest_plateau,
)

CAMERA = default_camera()
WEIGHT = np.array(
    [
        [1.01, 0.0, 0.0, 0.02, 0.0, 0.001],
        [0.0, 0.99, 0.01, 0.0, 0.3, -0.002],
        [0.0, 0.02, 1.0, 0.1, 0.2, 0.01],
    ]
)


def made_up(count: int, hidden: int) -> Calibration:
    """Blocks that follow `WEIGHT` but for the first `hidden`, which are centimetres off."""
    rng = np.random.default_rng(0)
    low = rng.uniform(0.1, 0.7, (count, 2))
    size = rng.uniform(0.05, 0.1, (count, 2))
    depth = rng.uniform(0.9, 1.3, (count, 1))
    locations = np.concatenate([low, low + size, depth], axis=1)
    in_camera = terms(locations, CAMERA) @ WEIGHT.T
    in_camera += rng.normal(0.0, 1e-4, in_camera.shape)
    in_camera[:hidden] += rng.uniform(0.02, 0.05, (hidden, 3))
    positions = in_camera @ CAMERA.pose.rotation().T + np.array(CAMERA.position)
    return Calibration(locations.astype(np.float32), positions, (CAMERA,) * count)


def test_the_map_is_found_in_spite_of_hidden_blocks() -> None:
    fit = fit_camera(made_up(400, hidden=60))
    np.testing.assert_allclose(fit.weight, WEIGHT, atol=5e-3)
    assert fit.median_m < 3e-4
    assert 0.7 < fit.used <= 0.85


def test_too_few_blocks_are_refused() -> None:
    with pytest.raises(CalibrationError, match="at least 100"):
        fit_camera(made_up(20, hidden=0))


def test_plateau_is_the_widest_of_the_highest() -> None:
    shares = np.where((SCORES > 0.2) & (SCORES < 0.6), 0.999, 0.5)
    shares = np.where((SCORES > -0.9) & (SCORES < -0.8), 1.0, shares)
    low, high = widest_plateau(SCORES, shares)
    assert low == pytest.approx(0.2, abs=2e-3)
    assert high == pytest.approx(0.6, abs=2e-3)
    with pytest.raises(CalibrationError, match="no threshold"):
        widest_plateau(SCORES, np.zeros_like(SCORES))


def test_a_match_is_likelier_than_not_unless_validation_says_otherwise() -> None:
    assert score_within(-0.1, 0.85) == 0.5
    assert score_within(0.6, 0.8) == pytest.approx(0.7)
    assert score_within(0.1, 0.4) == pytest.approx(0.25)


def test_certainty_becomes_the_share_that_is_right() -> None:
    """Logits of which the greatest is right as often as its probability says, made unsure."""
    rng = np.random.default_rng(1)
    sure = rng.normal(0.0, 3.0, (4000, 3))
    shares = np.exp(sure) / np.exp(sure).sum(axis=1, keepdims=True)
    drawn = (rng.random((4000, 1)) < shares.cumsum(axis=1)).argmax(axis=1)
    right = float(np.mean(drawn == sure.argmax(axis=1)))
    assert sharpness(sure, right) == pytest.approx(1.0, abs=0.1)
    assert sharpness(0.4 * sure, right) == pytest.approx(2.5, abs=0.25)
    assert sharpness(np.zeros((5, 3)), 0.9) == pytest.approx(4.0)
