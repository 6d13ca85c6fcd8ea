"""The report's plots."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from nsrm_harness.tables.paper import ROWS
from nsrm_harness.tables.results import Row, select, summarize

#: The split and the number of steps at which it stands; test has one and two.
STEPS = {"test": 1.5, "steps_3": 3, "steps_4": 4, "steps_5": 5, "steps_6": 6, "steps_8": 8}
PANELS = (("program", "program"), ("o1", "objects moved"), ("iou_3d", "IoU-3D"))
LINES = (
    ("nsrm", "mask", "tab:blue", "-", "NSRM, boxes from the mask"),
    ("nsrm", "detector", "tab:cyan", ":", "NSRM, boxes from the detector"),
    ("baseline", "mask", "tab:orange", "-", "baseline"),
)
PAPER = (("nsrm", "tab:blue", "paper, model"), ("baseline", "tab:orange", "paper, baseline"))


def draw_steps(rows: Sequence[Row], path: Path) -> None:
    """Accuracy against the number of steps, mean and range over the seeds, as a PNG."""
    figure, axes = plt.subplots(1, len(PANELS), figsize=(11.0, 4.1), layout="constrained")
    for axis, (measure, title) in zip(axes, PANELS, strict=True):
        _draw(rows, measure, axis)
        axis.set(title=title, xlabel="steps (trained on one and two)", ylim=(0.0, 102.0))
        axis.set_xticks([1.5, 3, 4, 5, 6, 8], ["1-2", "3", "4", "5", "6", "8"])
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("percent of the episodes")
    lines, labels = axes[1].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", ncols=len(labels), fontsize=9)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw(rows: Sequence[Row], measure: str, axis: Axes) -> None:
    for model, boxes, color, style, label in LINES:
        found = {
            steps: summary
            for split, steps in STEPS.items()
            if (summary := summarize(select(rows, split, model, boxes), measure)) is not None
        }
        if not found:
            continue
        means = [summary.mean for summary in found.values()]
        axis.fill_between(
            list(found),
            [summary.least for summary in found.values()],
            [summary.greatest for summary in found.values()],
            color=color,
            alpha=0.2,
            linewidth=0,
        )
        axis.plot(list(found), means, style, marker="o", ms=4, color=color, label=label)
    for model, color, label in PAPER:
        points = {
            steps: value
            for split, steps in STEPS.items()
            if (split, model) in ROWS
            and (value := getattr(ROWS[split, model], measure)) is not None
        }
        axis.plot(list(points), list(points.values()), "x--", color=color, label=label)
