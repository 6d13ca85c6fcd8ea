"""Reads the journal of a soak test: resources that processes hold over hours, and their speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from numpy.typing import NDArray

from nsrm_harness.common.number_text import or_dash
from nsrm_harness.evaluation.process_trials.journal import JournalError, Line

SAMPLES = 8
"""Smallest number of samples that allows a verdict."""
GROWTH = 0.02
"""Largest share by which a quantity may grow from the second quarter to the last."""
GROWTH_LEAST = {"rss_kib": 512.0, "handles": 3.0, "threads": 0.0, "files": 6.0, "bytes": 1e6}
"""Growth that is always allowed."""
SLOWER = 2.0
"""Largest ratio of a sentence's time in the last quarter to that in the second. A run is compared
with itself, so this only has to allow for other work on the machine."""
MINUTE_NS = 60_000_000_000

Series = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Soak:
    """The samples of a soak test.

    * `hours`: `[samples]`, time since the first sample
    * `held`: by node and quantity, `[samples]`
    * `shared`: number of files that processes share, and their bytes in memory, `[samples]`
    * `minutes`: `[minutes]`, end of each minute, in hours
    * `said_ms`: `[minutes, 3]`: p50, p99 and maximum time of the sentences done in a minute, from
      the start of the client's process to its end
    * `scene_ms`: `[samples]`, age of the latest scene's image when it was received
    * `sentences`: number of sentences done, and number that ended otherwise
    """

    hours: Series
    held: dict[str, dict[str, Series]]
    shared: dict[str, Series]
    minutes: Series
    said_ms: Series
    scene_ms: Series
    sentences: tuple[int, int]

    def faults(self) -> list[str]:
        """Quantities that have grown, and whether sentences take longer."""
        series = [
            (f"{node}: {what}", what, values)
            for node, quantities in self.held.items()
            for what, values in quantities.items()
        ]
        series += [(f"shared memory: {what}", what, values) for what, values in self.shared.items()]
        faults = []
        for name, what, values in series:
            early, late = _quarters(values)
            if late - early > max(GROWTH * early, GROWTH_LEAST[what]):
                faults.append(f"{name} has grown from {early:.0f} to {late:.0f}")
        # If no sentence was done, there is nothing to compare.
        if len(self.minutes) > 0:
            early, late = _quarters(self.said_ms[:, 0])
            if late > SLOWER * early:
                faults.append(f"a sentence, p50: {late:.0f} ms, {early:.0f} before")
        return faults

    def text(self) -> str:
        """A Markdown table for people."""
        done, other = self.sentences
        lines = [
            f"{self.hours[-1]:.2f} hours, {done} sentences done, {other} refused.",
            "",
            "| what | second quarter | last quarter |",
            "|---|---:|---:|",
        ]
        for node, quantities in self.held.items():
            for what, values in quantities.items():
                early, late = _quarters(values)
                lines.append(f"| {node}: {_WORDS[what]} | {early:.0f} | {late:.0f} |")
        for what, values in self.shared.items():
            early, late = _quarters(values)
            lines.append(f"| shared: {_WORDS[what]} | {early:.0f} | {late:.0f} |")
        for column, what in enumerate(("p50", "p99")):
            of = _quarters(self.said_ms[:, column]) if len(self.minutes) > 0 else (None, None)
            early, late = (or_dash(value, ".0f") for value in of)
            lines.append(f"| a sentence, {what} of a minute, ms | {early} | {late} |")
        early, late = _quarters(self.scene_ms)
        lines.append(f"| from picture to scene, ms | {early:.1f} | {late:.1f} |")
        return "\n".join(lines)


_WORDS = {
    "rss_kib": "resident memory, KiB",
    "handles": "open files",
    "threads": "threads",
    "files": "files",
    "bytes": "bytes in memory",
}


def _quarters(values: Series) -> tuple[float, float]:
    """Medians of the second and the last quarter; the first one includes the start-up."""
    quarter = max(len(values) // 4, 1)
    # A single sample has no second quarter.
    early = values[quarter : 2 * quarter] if len(values) > 1 else values
    return float(np.median(early)), float(np.median(values[-quarter:]))


def read_soak(lines: Sequence[Line]) -> Soak:
    """The samples in a journal. Raises `JournalError` if there are too few."""
    samples = [line for line in lines if line["what"] == "sample"]
    if len(samples) < SAMPLES:
        raise JournalError(f"the journal has {len(samples)} samples; {SAMPLES} are needed")
    begun_ns = samples[0]["t"]
    asked = {line["ask"]: line["t"] for line in lines if line["what"] == "ask"}
    answered = [line for line in lines if line["what"] == "answered"]
    done = [line for line in answered if line["code"] == 0]
    by_minute: dict[int, list[float]] = {}
    # The incomplete last minute counts with the one before it: few samples have a low maximum.
    last = max((samples[-1]["t"] - begun_ns) // MINUTE_NS - 1, 0)
    for line in done:
        minute = min((line["t"] - begun_ns) // MINUTE_NS, last)
        by_minute.setdefault(minute, []).append((line["t"] - asked[line["ask"]]) / 1e6)
    minutes = sorted(by_minute)

    def series(*path: str) -> Series:
        values = []
        for sample in samples:
            value = sample
            for name in path:
                value = value[name]
            values.append(value)
        return np.array(values, dtype=np.float64)

    nodes = samples[0]["nodes"]
    return Soak(
        hours=(series("t") - begun_ns) / 3.6e12,
        held={
            node: {what: series("nodes", node, what) for what in ("rss_kib", "handles", "threads")}
            for node in nodes
        },
        shared={what: series("shared", what) for what in ("files", "bytes")},
        minutes=(np.array(minutes, dtype=np.float64) + 1.0) / 60.0,
        said_ms=np.array(
            [
                [*np.percentile(by_minute[minute], [50, 99]), max(by_minute[minute])]
                for minute in minutes
            ]
        ).reshape(-1, 3),
        scene_ms=series("scenes", "latency_ns") / 1e6,
        sentences=(len(done), len(answered) - len(done)),
    )


def draw(soak: Soak, path: Path) -> None:
    """Plots memory, open files, shared memory and times against the hours, as a PNG."""
    figure, axes = plt.subplots(2, 2, figsize=(11.0, 6.6), layout="constrained")
    for axis, what, title, scale in (
        (axes[0, 0], "rss_kib", "resident memory, MiB", 1024.0),
        (axes[0, 1], "handles", "open files", 1.0),
    ):
        for node, quantities in soak.held.items():
            axis.plot(soak.hours, quantities[what] / scale, label=node)
        axis.set_title(title)
        axis.legend(loc="lower right", ncols=2, fontsize=9)
    axes[1, 0].plot(soak.hours, soak.shared["bytes"] / 2**20, color="tab:purple")
    axes[1, 0].set_title("in shared memory, MiB")
    for column, (name, line) in enumerate((("p50", "-"), ("p99", "--"), ("greatest", ":"))):
        axes[1, 1].plot(soak.minutes, soak.said_ms[:, column], line, color="tab:blue", label=name)
    axes[1, 1].plot(soak.hours, soak.scene_ms, color="tab:green", label="picture to scene", lw=0.7)
    axes[1, 1].set_title("time of a sentence with its moves, by minutes, ms")
    axes[1, 1].set_yscale("log")
    axes[1, 1].legend(fontsize=9)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
        axis.set_xlabel("hours")
        if axis is not axes[1, 1]:
            axis.set_ylim(0.0, 1.15 * axis.dataLim.y1)
    figure.savefig(path, dpi=110)
    plt.close(figure)
