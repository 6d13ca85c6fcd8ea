"""Plots how the work of a plan grows with what is in the scene, the sentence and the domain."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

from nsrm_harness.common.errors import HarnessError

COLUMNS = ("axis", "size", "instructions")


class GrowthError(HarnessError):
    """Counts that cannot be read."""


Counts = dict[str, list[tuple[int, int]]]
"""For each axis the sizes and their numbers of instructions."""


def read(path: Path) -> Counts:
    """The counts of a file. Raises `GrowthError`."""
    counts: Counts = {}
    advice = "write it with 'cargo run --release -p nsrm-bench --bin growth'"
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = csv.DictReader(file)
            if tuple(rows.fieldnames or ()) != COLUMNS:
                raise GrowthError(f"{path}: expected the columns {','.join(COLUMNS)}: {advice}")
            for row in rows:
                pair = int(row["size"]), int(row["instructions"])
                counts.setdefault(row["axis"], []).append(pair)
    except (OSError, ValueError) as error:
        raise GrowthError(f"{path}: cannot read the counts: {error}: {advice}") from error
    if not counts:
        raise GrowthError(f"{path}: there are no counts in it: {advice}")
    return counts


def draw(counts: Counts, path: Path) -> None:
    """A panel for each axis; a dashed line is what would be proportional to the smallest size."""
    figure, panels = plt.subplots(
        1, len(counts), figsize=(2.9 * len(counts), 3.0), layout="constrained", squeeze=False
    )
    for panel, (axis, points) in zip(panels[0], counts.items(), strict=True):
        sizes = [size for size, _ in points]
        thousands = [instructions / 1000 for _, instructions in points]
        panel.plot(sizes, thousands, "o-", color="tab:blue", markersize=4)
        proportional = [thousands[0] * size / sizes[0] for size in sizes]
        panel.plot(sizes, proportional, "--", color="0.6", linewidth=0.9)
        panel.set(
            xlabel=axis if axis != "tokens" else "tokens (parsed only)",
            ylim=(0.0, 1.6 * max(thousands)),
            xlim=(0, None),
        )
        panel.grid(alpha=0.3)
    panels[0][0].set_ylabel("thousand instructions")
    figure.savefig(path, dpi=110)
    plt.close(figure)
