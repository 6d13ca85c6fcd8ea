"""Reads what was measured of how fast processes answer, and draws it."""

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

ALONE, ABOVE = ", computation alone", ", above it"
"""What is added to a row's name for its computation, and for what it takes beside that."""
PIPE, EVENT = ("pipe", ""), ("event", "")
"""The rows of waking another process and being woken by it."""


class LatencyError(HarnessError):
    """Measurements that can't be read."""


@dataclass(frozen=True, eq=False)
class LatencySamples:
    """What was measured.

    * `us`: rising, microseconds
    """

    us: NDArray[np.float64]

    def at(self, share: float) -> float:
        """The time within which this share lies, microseconds."""
        return float(np.quantile(self.us, share, method="inverted_cdf"))

    @property
    def count(self) -> int:
        """How many were measured."""
        return len(self.us)


Rows = dict[tuple[str, str], LatencySamples]
"""By what was measured and how."""


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
        raise LatencyError(f"{path}: rows are missing: the measurement was broken off")
    return rows


def table(rows: Rows) -> str:
    """For a person: a table in Markdown, and what lies between the rows."""
    lines = [
        "| microseconds | p50 | p99 | p99.99 | most | measured |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for key, times in rows.items():
        shares = [f"{times.at(share):.1f}" for share in (0.5, 0.99, 0.9999, 1.0)]
        lines.append(f"| {_title(*key)} | {' | '.join(shares)} | {times.count:,} |")
    lines.append("")
    for (what, how), times in rows.items():
        row, above, _ = what.partition(ABOVE)
        if not above:
            continue
        text = f"{_title(row, how)}: {times.at(0.5):.1f} µs above the computation alone (p50)"
        if how == "waiting":
            text += f", {times.at(0.5) / rows[PIPE].at(0.5):.2f} of a pipe's way there and back"
        lines.append(f"- {text}.")
    event = rows[EVENT].at(0.5) / rows[PIPE].at(0.5)
    lines.append(f"- A frame to another process that waits: {event:.2f} of a pipe's way.")
    small, large = (rows[key].at(0.5) for key in rows if key[0] == "hand-over")
    lines.append(f"- A frame of 27 times the pixels: {large / small:.2f} of the time (p50).")
    return "\n".join(lines)


def _title(what: str, how: str) -> str:
    names = {
        "pipe": "a byte by a pipe to another process that waits, and word of it back",
        "event": "a frame to another process that waits, and word of it back",
        "sentence": "sentence to first sub-goal",
        "frame": "frame to scene",
        "hand-over": "frame to another process that spins, and word of it back",
    }
    name, _, alone = what.partition(",")
    return names[name] + (f",{alone}" if alone else "") + (f", {how}" if how else "")


def draw(rows: Rows, path: Path) -> None:
    """Share of what takes longer, against the time, as a PNG."""
    figure, axes = plt.subplots(1, 3, figsize=(12.0, 4.8), layout="constrained", sharey=True)
    for axis, what, title in zip(
        axes,
        ("sentence", "frame", "hand-over"),
        ("sentence to first sub-goal", "frame to scene", "frame to another process, and back"),
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
            _tail(axis, rows[key], "tab:gray", line, f"{key[0]}, there and back")
        axis.set(title=title, xlabel="microseconds", xscale="log", yscale="log")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    axes[0].set_ylabel("share that takes longer")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _tail(axis: Axes, times: LatencySamples, color: str, line: str, label: str) -> None:
    # The last one has none behind it, which has no logarithm.
    longer = 1.0 - np.arange(1, times.count) / times.count
    axis.step(times.us[:-1], longer, line, color=color, label=label, where="post")
