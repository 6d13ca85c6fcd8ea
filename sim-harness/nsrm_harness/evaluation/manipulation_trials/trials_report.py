"""Reports the results of the trials: a Markdown table, a CSV file and a plot."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from numpy.typing import NDArray

from nsrm_harness.evaluation.manipulation_trials.confidence_interval import is_worse
from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementVerdict
from nsrm_harness.evaluation.manipulation_trials.rows import TrialRow

CORRECTED_MM = 1.0
ENOUGH = 100
"""From this many episodes on, a row's median and 95 % quantile are compared with these limits:"""
OFF_P50_MM, OFF_P95_MM, CONTROL_P95_MM = 2.0, 5.0, 0.5
SECONDS_P50 = 6.0
REFUSED = 0.01
"""Largest share of sub-goals that may be refused."""
FIELDS = (
    "row",
    "episodes",
    "succeeded",
    "refused",
    "failed",
    "position_p50_mm",
    "position_p95_mm",
    "seconds_p50",
)
NONE = "–"
"""Shown to people where there is nothing to compute a figure from."""
GIVEN_UP = "given_up"
"""Last column of tables with disturbed rows: how many of the successes were correctly given up."""


@dataclass(frozen=True, eq=False)
class RowResult:
    """A row of the table with its episodes."""

    row: TrialRow
    ended: tuple[EpisodeResult, ...]

    @property
    def ends(self) -> Counter[str]:
        """How many episodes ended in each way."""
        return Counter(each.end for each in self.ended)

    @property
    def given_up(self) -> int:
        """Successes in which the impossible was given up with a reason, with the arm at rest."""
        return sum(each.end == "succeeded" and bool(each.why) for each in self.ended)

    @property
    def steps(self) -> list[PlacementVerdict]:
        """All steps that were executed."""
        return [step for each in self.ended for step in each.steps]

    @property
    def refused(self) -> int:
        """Number of refused sub-goals."""
        return sum(bool(each.kind) for each in self.ended)

    @property
    def asked(self) -> int:
        """Number of sub-goals, refused ones included."""
        return len(self.steps) + self.refused

    @property
    def off_mm(self) -> NDArray[np.float64]:
        """Distance of each step from the true relation; in a disturbed row, of its last attempt,
        unless it was correctly given up."""
        steps = self.steps
        if self.row.is_disturbed:
            steps = [step for each in self.ended for step in _last(each)]
        return 1000 * np.array([step.off_m for step in steps])

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Simulated time of each step."""
        return np.array([step.seconds for step in self.steps])

    def values(self) -> tuple[str, ...]:
        """The fields of the CSV file; empty if there is no step."""
        ends = self.ends
        return (
            self.row.name,
            str(len(self.ended)),
            *(str(ends[end]) for end in ("succeeded", "refused", "failed")),
            *(_decimals(_quantile(self.off_mm, share)) for share in (0.5, 0.95)),
            _decimals(_quantile(self.seconds, 0.5)),
        )


def _last(ended: EpisodeResult) -> list[PlacementVerdict]:
    """The last attempt at each step, without the step that was correctly given up."""
    last = {step.step: step for step in ended.steps}
    if ended.end == "succeeded" and ended.why and ended.steps:
        del last[ended.steps[-1].step]
    return [last[step] for step in sorted(last)]


def _quantile(values: NDArray[np.float64], share: float) -> float | None:
    return float(np.quantile(values, share)) if len(values) else None


def _decimals(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def counted(rows: Sequence[TrialRow], ended: Sequence[EpisodeResult]) -> list[RowResult]:
    """Groups the results of the episodes by row."""
    return [RowResult(row, tuple(each for each in ended if each.row == row.name)) for row in rows]


def text(lines: Sequence[RowResult]) -> str:
    """A Markdown table for people, and the reason of each episode that did not succeed."""
    disturbed = _has_disturbed(lines)
    columns = ["", "episodes", "succeeded", "goal", "refused", "failed", "error, p50", "p95"]
    columns.append("seconds per step")
    if disturbed:
        columns.insert(3, "correctly given up")
    rows = [_columns(columns), "|---|" + (len(columns) - 1) * "---:|"]
    for line in lines:
        _, episodes, succeeded, refused, failed, half, most, seconds = line.values()
        shares = [_percent(int(succeeded) - line.given_up, int(episodes))]
        if disturbed:
            shares.append(_percent(line.given_up, int(episodes)))
        goal = f"{100 * line.row.goal:.1f} %" if line.row.goal else NONE
        off = (f"{value} mm" if value else NONE for value in (half, most))
        ends = [goal, refused, failed, *off, seconds or NONE]
        rows.append(_columns([line.row.title, episodes, *shares, *ends]))
    rows.extend(["", *_beside(lines), ""])
    rows.extend(
        f"- {each.row} {each.index}: {each.end}: {each.why}"
        for each in _aimed(lines)
        if each.end != "succeeded"
    )
    return "\n".join(rows)


def _columns(texts: Sequence[str]) -> str:
    """A row of a Markdown table."""
    return f"| {' | '.join(texts)} |".replace("|  |", "| |")


def _beside(lines: Sequence[RowResult]) -> list[str]:
    """Remarks on all rows together."""
    told = []
    # The other rows are given true poses and sub-goals, or have no closed loop.
    if by_model := [line for line in lines if line.row.goal and not line.row.is_control]:
        ended = [each for line in by_model for each in line.ended]
        kinds = Counter(each.kind for each in ended if each.kind)
        asked, count = sum(line.asked for line in by_model), sum(kinds.values())
        refused = ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items())) or "none"
        corrected_mm = 1000 * np.array([by for each in ended for by in each.corrected_m])
        told = [
            f"- Of {asked} sub-goals of the model, refused: {refused} ({_percent(count, asked)})."
        ]
        if len(corrected_mm):
            much = _percent(int((corrected_mm > CORRECTED_MM).sum()), len(corrected_mm))
            told.append(
                f"- Sub-goals of the model that were corrected by what is seen below them: "
                f"{much} by more than {CORRECTED_MM} mm, {np.median(corrected_mm):.1f} mm in the "
                f"median, {corrected_mm.max():.1f} mm at most."
            )
    if undisturbed := [line for line in lines if not line.row.is_disturbed]:
        touched = sum(bool(step.touched) for line in undisturbed for step in line.steps)
        told.append(f"- Steps with an unexpected contact of the arm or its block: {touched}.")
    if _has_disturbed(lines):
        told.append(
            "- Errors in disturbed rows: each step at its last attempt, without the steps that "
            "were correctly given up."
        )
    again = sum(tries > 1 for line in lines for each in line.ended for tries in each.tries)
    return [*told, f"- Sub-goals that took more than one try: {again}."]


def _has_disturbed(lines: Sequence[RowResult]) -> bool:
    return any(line.row.is_disturbed for line in lines)


def missed(lines: Sequence[RowResult]) -> list[str]:
    """Lists the missed goals: rows that do significantly worse than their goal; in undisturbed rows
    also unexpected contacts and, from `ENOUGH` episodes on, too many refused sub-goals and steps
    that were too inaccurate or too slow in simulated time."""
    found = []
    for line in lines:
        episodes, succeeded = len(line.ended), line.ends["succeeded"]
        if is_worse(succeeded, episodes, line.row.goal):
            found.append(
                f"{line.row.title}: {succeeded} of {episodes} succeeded, "
                f"the goal is {100 * line.row.goal:.1f} %"
            )
        if line.row.is_disturbed:
            continue
        if episodes >= ENOUGH:
            found += [f"{line.row.title}: {what}" for what in _too_much(line)]
        touched = [pair for step in line.steps for pair in step.touched]
        if touched:
            pairs = ", ".join(sorted(set(touched)))
            found.append(f"{line.row.title}: unexpected contact: {pairs}")
    return found


def _too_much(line: RowResult) -> list[str]:
    """Violations of the limits that all rows share."""
    p95_mm = CONTROL_P95_MM if line.row.is_control else OFF_P95_MM
    told = [
        f"{what.format(value)}, the goal is {most}"
        for value, most, what in (
            (_quantile(line.off_mm, 0.5), OFF_P50_MM, "median error {:.2f} mm"),
            (_quantile(line.off_mm, 0.95), p95_mm, "95 % error {:.2f} mm"),
            (_quantile(line.seconds, 0.5), SECONDS_P50, "median {:.2f} s per step"),
        )
        if value is not None and value > most
    ]
    if line.refused > REFUSED * line.asked:
        told.append(
            f"{line.refused} of {line.asked} sub-goals refused, the goal is {100 * REFUSED:.0f} %"
        )
    return told


def _percent(count: int, whole: int) -> str:
    return f"{100 * count / max(whole, 1):.1f} %"


def worst(lines: Sequence[RowResult], count: int) -> list[EpisodeResult]:
    """The worst episodes of rows with a goal: failed, then refused, then the largest errors."""
    order = ("failed", "refused", "succeeded")
    return sorted(_aimed(lines), key=lambda each: (order.index(each.end), -_off_m(each)))[:count]


def best(lines: Sequence[RowResult], count: int) -> list[EpisodeResult]:
    """The best episodes of rows with a goal: most steps, then the smallest errors."""
    done = [each for each in _aimed(lines) if each.end == "succeeded"]
    return sorted(done, key=lambda each: (-len(each.steps), _off_m(each)))[:count]


def _aimed(lines: Sequence[RowResult]) -> list[EpisodeResult]:
    return [each for line in lines if line.row.goal for each in line.ended]


def _off_m(ended: EpisodeResult) -> float:
    return max((step.off_m for step in ended.steps), default=0.0)


def write_csv(lines: Sequence[RowResult], path: Path) -> None:
    """Writes one line per row."""
    disturbed = _has_disturbed(lines)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow((*FIELDS, GIVEN_UP) if disturbed else FIELDS)
        for line in lines:
            writer.writerow((*line.values(), line.given_up) if disturbed else line.values())


def draw(lines: Sequence[RowResult], path: Path) -> None:
    """Plots how the episodes ended, and the errors and times of steps in rows with a goal, as a
    PNG."""
    figure, (ends, off, seconds) = plt.subplots(1, 3, figsize=(16.0, 4.2), layout="constrained")
    names = [line.row.title for line in lines]
    left = np.zeros(len(lines))
    given_up = [line.given_up for line in lines]
    counts = {
        ("succeeded", "tab:green"): [line.ends["succeeded"] - line.given_up for line in lines],
        ("correctly given up", "yellowgreen"): given_up,
        ("refused", "gold"): [line.ends["refused"] for line in lines],
        ("failed", "tab:red"): [line.ends["failed"] for line in lines],
    }
    for (label, color), count in counts.items():
        if count is given_up and not any(given_up):
            continue
        shares = 100 * np.array(count) / [max(len(line.ended), 1) for line in lines]
        ends.barh(names, shares, left=left, color=color, label=label)
        left += shares
    aimed = [line.row for line in lines if line.row.goal]
    goals, titles = [100 * row.goal for row in aimed], [row.title for row in aimed]
    ends.scatter(goals, titles, marker="|", s=300, c="black")
    least = min(100 * line.ends["succeeded"] / max(len(line.ended), 1) for line in lines)
    ends.set(
        title="how episodes ended (goal: |)", xlabel="percent", xlim=(80 if least > 82 else 0, 100)
    )
    ends.invert_yaxis()
    # Outside the axes, which the bars fill.
    ends.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=4)
    for line in lines:
        if not line.row.goal:
            continue
        for axis, values in ((off, np.sort(line.off_mm)), (seconds, np.sort(line.seconds))):
            if len(values):
                axis.step(values, np.arange(1, len(values) + 1) / len(values), label=line.row.title)
    off.set(title="distance from the true relation", xlabel="millimetres", ylabel="share of steps")
    off.set_xscale("log")
    seconds.set(title="simulated time of a step", xlabel="seconds")
    for axis in (off, seconds):
        axis.grid(alpha=0.3)
    if aimed:
        # Outside the axes, which the curves fill.
        seconds.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.02, 1.0))
    figure.savefig(path, dpi=110)
    plt.close(figure)
