"""Plots a report: risk against coverage, and the calibration of confidences."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from nsrm_harness.evaluation.refusals.certainty import calibration_error
from nsrm_harness.evaluation.refusals.measure import RefusalReport

#: Confidences cluster near 1, so 1 - confidence is plotted, down to this value.
LEAST_DOUBT = 1e-5


def draw_report(report: RefusalReport, path: Path) -> None:
    """Draws both diagrams as a PNG."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
    _draw_risk(report, left)
    _draw_calibration(report, right)
    figure.suptitle(f"{report.set}: good sentences and sentences to refuse, equally weighted")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_risk(report: RefusalReport, axis: Axes) -> None:
    curve = report.curve
    axis.step(curve.coverage, curve.risk, where="post", color="tab:blue")
    axis.axvline(0.5, color="0.6", linestyle=":", linewidth=1)
    axis.set(
        title="risk against coverage",
        xlabel="share of sentences accepted (0.5: all good ones, no other)",
        ylabel="share of accepted that is wrong",
        xlim=(0.0, max(0.55, float(curve.coverage.max(initial=0.0)) * 1.05)),
        ylim=(0.0, None),
    )
    axis.grid(alpha=0.3)


def _draw_calibration(report: RefusalReport, axis: Axes) -> None:
    doubts = np.geomspace(LEAST_DOUBT, 1.0, 200)
    axis.plot(doubts, 1.0 - doubts, color="0.6", linestyle=":", linewidth=1, label="calibrated")
    for name, parts, color in (
        ("all plans", report.mixed_bins, "tab:orange"),
        ("plans for good sentences", report.good_bins, "tab:green"),
    ):
        axis.plot(
            [max(1.0 - part.confidence, LEAST_DOUBT) for part in parts],
            [part.right for part in parts],
            "o-",
            ms=4,
            color=color,
            label=f"{name}, error {calibration_error(parts):.3f}",
        )
    axis.set(
        title=f"reliability, {len(report.mixed_bins)} bins of equal mass",
        xlabel="mean doubt: 1 - confidence",
        ylabel="share right",
        xscale="log",
        xlim=(1.0, LEAST_DOUBT),
        ylim=(0.0, 1.02),
    )
    axis.legend(loc="lower right")
    axis.grid(alpha=0.3)
