"""Draws the report's plots."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import fmean

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import TABLEAU_COLORS

from nsrm_harness.paper.tables.compare import Comparison
from nsrm_harness.paper.tables.published_figures import ROWS
from nsrm_harness.paper.tables.results import ResultRow, select, summarize
from nsrm_harness.paper.tables.study import Study
from nsrm_harness.paper.tables.variants import UNDISTURBED as NONE

#: Where each split is plotted, in steps; test has one and two.
STEPS = {"test": 1.5, "steps_3": 3, "steps_4": 4, "steps_5": 5, "steps_6": 6, "steps_8": 8}
PANELS = (("program", "program"), ("o1", "objects moved"), ("iou_3d", "IoU-3D"))
LINES = (
    ("nsrm", "mask", "tab:blue", "-", "NSRM, boxes from the mask"),
    ("nsrm", "detector", "tab:cyan", ":", "NSRM, boxes from the detector"),
    ("baseline", "mask", "tab:orange", "-", "baseline"),
)
PAPER = (("nsrm", "tab:blue", "paper, model"), ("baseline", "tab:orange", "paper, baseline"))


def draw_steps(rows: Sequence[ResultRow], path: Path) -> None:
    """Plots accuracy against the number of steps, mean and range over the seeds, as a PNG."""
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


def draw_comparison(
    comparison: Comparison, rows: Sequence[ResultRow], study: Study, path: Path
) -> None:
    """Plots accuracy against the size of each disturbance, and against the number of training
    episodes, as a PNG."""
    figure, axes = plt.subplots(2, 2, figsize=(11.0, 7.4), layout="constrained")
    for (left, right), (measure, title) in zip(axes, (PANELS[0], PANELS[2]), strict=True):
        _draw_disturbed(comparison, measure, left)
        left.set(title=f"{title}, disturbed scenes", xlabel="size of the disturbance")
        _draw_sizes(comparison, rows, study, measure, right)
        right.set(title=f"{title}, test", xlabel="episodes for training")
        for axis in (left, right):
            axis.set_ylabel("percent")
            axis.grid(alpha=0.3)
    lines, labels = axes[0, 0].get_legend_handles_labels()
    columns = max(len(labels) // 2, 1)
    figure.legend(lines, labels, loc="outside lower center", ncols=columns, fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_disturbed(comparison: Comparison, measure: str, axis: Axes) -> None:
    kinds = list(dict.fromkeys(each.kind for each, _ in comparison.disturbed if each.size > 0.0))
    for color, kind in zip(TABLEAU_COLORS, kinds, strict=False):
        points = [(each.size, of) for each, of in comparison.disturbed if each.kind in (kind, NONE)]
        for model in dict.fromkeys(row.model for _, of in points for row in of):
            means = [
                fmean(getattr(row, measure) or 0.0 for row in of if row.model == model)
                for _, of in points
            ]
            style, label = ("-", kind) if model == "nsrm" else ("--", f"{kind}, {model}")
            sizes = [size for size, _ in points]
            axis.plot(sizes, means, style, marker="o", ms=4, color=color, label=label)


def _draw_sizes(
    comparison: Comparison, rows: Sequence[ResultRow], study: Study, measure: str, axis: Axes
) -> None:
    count = study.settings("train").count
    points = {count: summarize(select(rows, "test", "nsrm", "mask"), measure)}
    for row in comparison.rows:
        number, _, unit = row.model.partition(" ")
        if unit == "episodes" and row.split == "test":
            points[int(number)] = summarize([row], measure)
    found = sorted((at, summary.mean) for at, summary in points.items() if summary is not None)
    counts = [at for at, _ in found]
    axis.plot(counts, [mean for _, mean in found], marker="o", color="tab:blue")
    axis.set_xscale("log")
    axis.set_xticks(counts, list(map(str, counts)))
    axis.minorticks_off()


def _draw(rows: Sequence[ResultRow], measure: str, axis: Axes) -> None:
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
