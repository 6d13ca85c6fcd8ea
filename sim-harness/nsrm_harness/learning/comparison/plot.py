"""Plots the times of `cargo compare`."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

from nsrm_harness.common.errors import HarnessError

COLUMNS = ("job", "contender", "p50_us", "p99_us", "p9999_us")
COLORS = {
    "empty": "0.6",
    "nsrm": "tab:blue",
    "nsrm-plain": "steelblue",
    "onnxruntime": "chocolate",
    "tract": "tab:green",
    "candle": "tab:red",
    "onnxruntime-python": "tab:brown",
    "jax": "tab:purple",
}
"""Of each contender's bars."""


class ComparisonError(HarnessError):
    """Times that cannot be read."""


Times = dict[str, dict[str, tuple[float, float]]]
"""For each job and contender the p50 and the p99, microseconds."""


def read(path: Path) -> Times:
    """The times of a file. Raises `ComparisonError`."""
    times: Times = {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = csv.DictReader(file)
            if tuple(rows.fieldnames or ()) != COLUMNS:
                raise ComparisonError(
                    f"{path}: expected the columns {','.join(COLUMNS)}: "
                    "name a file that 'cargo compare' has written"
                )
            for row in rows:
                pair = float(row["p50_us"]), float(row["p99_us"])
                times.setdefault(row["job"], {})[row["contender"]] = pair
    except (OSError, ValueError) as error:
        raise ComparisonError(f"{path}: cannot read the times: {error}") from error
    if not times:
        raise ComparisonError(f"{path}: there are no times in it: run 'cargo compare' again")
    return times


def draw(times: Times, path: Path) -> None:
    """Plots a bar for each job and contender on a logarithmic axis, with a mark at its p99."""
    contenders = list(dict.fromkeys(name for of in times.values() for name in of))
    figure, axis = plt.subplots(figsize=(12.0, 5.2), layout="constrained")
    width = 0.85 / len(contenders)
    for at, name in enumerate(contenders):
        have = [(place, of[name]) for place, of in enumerate(times.values()) if name in of]
        places = [place + (at - (len(contenders) - 1) / 2) * width for place, _ in have]
        middle = [p50 for _, (p50, _) in have]
        color = COLORS.get(name, "black")
        axis.bar(places, middle, 0.92 * width, color=color, label=name)
        tails = [p99 for _, (_, p99) in have]
        axis.vlines(places, middle, tails, color="0.2", linewidth=0.8)
        axis.plot(places, tails, "_", color="0.2", markersize=6)
        for place, value in zip(places, middle, strict=True):
            text = f"{value:.0f}" if value >= 10 else f"{value:.2g}"
            axis.text(
                place, value * 0.9, text, ha="center", va="top", rotation=90, fontsize=7, color="w"
            )
    least = min(p50 for of in times.values() for p50, _ in of.values())
    axis.set(
        yscale="log",
        ylim=(least / 8, None),
        ylabel="µs a run on one core: bars p50, marks p99",
        xlim=(-0.5, len(times) - 0.5),
    )
    axis.set_xticks(range(len(times)), list(times))
    axis.grid(axis="y", alpha=0.3)
    axis.set_axisbelow(True)
    figure.legend(loc="outside upper center", ncols=len(contenders), fontsize=9)
    figure.savefig(path, dpi=110)
    plt.close(figure)
