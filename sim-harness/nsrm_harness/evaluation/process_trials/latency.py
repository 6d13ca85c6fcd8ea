"""Reads the latencies of a robot's processes from a file, and prints and plots them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from numpy.typing import NDArray

from nsrm_harness.common.errors import HarnessError

ALONE, OVERHEAD = ", computation alone", ", overhead"
"""Suffixes of a row's name: its computation alone, and what the row takes longer than that."""
PIPE, EVENT = ("pipe", ""), ("event", "")
"""The rows for waking another process and being woken by it."""


class LatencyError(HarnessError):
    """Measurements that cannot be read."""


@dataclass(frozen=True, eq=False)
class LatencySamples:
    """The samples of one row.

    * `us`: microseconds, in ascending order
    """

    us: NDArray[np.float64]

    def at(self, share: float) -> float:
        """The time within which this share of the samples lies, microseconds."""
        return float(np.quantile(self.us, share, method="inverted_cdf"))

    @property
    def count(self) -> int:
        """Number of samples."""
        return len(self.us)


Rows = dict[tuple[str, str], LatencySamples]
"""Samples by what was measured and how."""


def read(path: Path) -> Rows:
    """The rows of a file. Raises `LatencyError`."""
    rows: Rows = {}
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            row = json.loads(line)
            us = np.array(row["times_ns"], dtype=np.float64) / 1000.0
            rows[row["what"], row["how"]] = LatencySamples(us)
    except (OSError, ValueError, KeyError) as error:
        raise LatencyError(f"{path}: {error}") from error
    if not {PIPE, EVENT} <= rows.keys():
        raise LatencyError(f"{path}: rows are missing: the measurement was interrupted")
    return rows


def table(rows: Rows) -> str:
    """A Markdown table for people, with the differences between the rows."""
    lines = [
        "| microseconds | p50 | p99 | p99.99 | maximum | samples |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for key, times in rows.items():
        shares = [f"{times.at(share):.1f}" for share in (0.5, 0.99, 0.9999, 1.0)]
        lines.append(f"| {_title(*key)} | {' | '.join(shares)} | {times.count:,} |")
    lines.append("")
    for (what, how), times in rows.items():
        row, overhead, _ = what.partition(OVERHEAD)
        if not overhead:
            continue
        text = f"{_title(row, how)}: {times.at(0.5):.1f} µs above the computation alone (p50)"
        if how == "waiting":
            text += f", {times.at(0.5) / rows[PIPE].at(0.5):.2f} of a pipe's round trip"
        lines.append(f"- {text}.")
    event = rows[EVENT].at(0.5) / rows[PIPE].at(0.5)
    lines.append(f"- A frame to a waiting process: {event:.2f} of a pipe's round trip.")
    small, large = (rows[key].at(0.5) for key in rows if key[0] == "hand-over")
    lines.append(f"- A frame with 27 times the pixels: {large / small:.2f} of the time (p50).")
    return "\n".join(lines)


def _title(what: str, how: str) -> str:
    names = {
        "pipe": "a byte through a pipe to a waiting process, round trip",
        "event": "a frame to a waiting process, round trip",
        "sentence": "sentence to first sub-goal",
        "frame": "frame to scene",
        "hand-over": "frame to a spinning process, round trip",
    }
    name, _, alone = what.partition(",")
    return names[name] + (f",{alone}" if alone else "") + (f", {how}" if how else "")


def draw(rows: Rows, path: Path) -> None:
    """Plots the share of samples that take longer, against time, as a PNG."""
    figure, axes = plt.subplots(1, 3, figsize=(12.0, 4.8), layout="constrained", sharey=True)
    for axis, what, title in zip(
        axes,
        ("sentence", "frame", "hand-over"),
        ("sentence to first sub-goal", "frame to scene", "frame to another process, round trip"),
        strict=True,
    ):
        colors = iter(("tab:blue", "tab:orange"))
        for key, times in rows.items():
            if key[0] != what:
                continue
            color = next(colors)
            _tail(axis, times, color, "-", key[1])
            if alone := rows.get((what + ALONE, key[1])):
                _tail(axis, alone, color, ":", f"{key[1]}, computation alone")
        for key, line in ((PIPE, "--"), (EVENT, "-.")):
            _tail(axis, rows[key], "tab:gray", line, f"{key[0]}, round trip")
        axis.set(title=title, xlabel="microseconds", xscale="log", yscale="log")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    axes[0].set_ylabel("share that takes longer")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _tail(axis: Axes, times: LatencySamples, color: str, line: str, label: str) -> None:
    # No sample is longer than the last one, and zero has no logarithm.
    longer = 1.0 - np.arange(1, times.count) / times.count
    axis.step(times.us[:-1], longer, line, color=color, label=label, where="post")
