"""Reports the speed measurements: Markdown tables, CSV files and a plot."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from numpy.typing import NDArray

from nsrm_harness.evaluation.manipulation_trials.speed.checks import BLOCKS, GOAL_S, CheckTimes
from nsrm_harness.evaluation.manipulation_trials.speed.measure_speed import Speed
from nsrm_harness.evaluation.manipulation_trials.speed.profile import PARTS, Profiled

SPEED_FIELDS = (
    "workers",
    "count",
    "episodes",
    "sub_goals",
    "start_s",
    "work_s",
    "episodes_a_minute",
    "sub_goals_a_minute",
    "late",
)
PROFILE_FIELDS = ("part", "seconds", "share", "entered")
CHECKS_FIELDS = ("where", "holds", "asked", "configurations", "p50_ms", "p99_ms", "most_ms")
TOUCHES, FREE = "touches", "free"


def seconds(profile: Sequence[Profiled]) -> dict[str, float]:
    """Time of each part over all episodes."""
    return {part: sum(each.seconds[part] for each in profile) for part in PARTS}


def shares(profile: Sequence[Profiled]) -> dict[str, float]:
    """Share of each part in the whole time."""
    whole_s = sum(each.profiled_took.clock_s for each in profile)
    return {part: of_s / whole_s for part, of_s in seconds(profile).items()}


def text(speed: Speed) -> str:
    """Three Markdown tables for people."""
    return "\n".join(
        (
            f"On {speed.processors} processors, load {speed.load:.1f} at the start:",
            "",
            *_throughput(speed),
            "",
            *_profile(speed.profile),
            "",
            *_checks(speed.looks),
        )
    )


def _throughput(speed: Speed) -> list[str]:
    lines = [
        "| workers | episodes per minute | sub-goals per minute | relative to one process "
        "| start |",
        "|---|---:|---:|---:|---:|",
    ]
    one = speed.throughput[0].episodes_a_minute
    lines += [
        f"| {each.title} | {each.episodes_a_minute:.1f} | {each.sub_goals_a_minute:.1f} "
        f"| {each.episodes_a_minute / one:.2f} | {each.start_s:.1f} s |"
        for each in speed.throughput
    ]
    lines += ["", f"- {len(speed.profile)} episodes each, from all rows in turn."]
    lines += [
        f"- {each.title}: {each.late} of them started late, within the measured time."
        for each in speed.throughput
        if each.late
    ]
    return lines


def _profile(profile: Sequence[Profiled]) -> list[str]:
    count = len(profile)
    lines = [
        "| where the time of one process goes | share | ms per episode | calls per episode |",
        "|---|---:|---:|---:|",
    ]
    of_parts, of_whole = seconds(profile), shares(profile)
    for part in sorted(PARTS, key=lambda part: of_parts[part], reverse=True):
        calls = sum(each.entered[part] for each in profile) / count
        lines.append(
            f"| {PARTS[part]} | {100 * of_whole[part]:.1f} % | {1000 * of_parts[part] / count:.0f} "
            f"| {calls:.0f} |"
        )
    plain, watched = (
        np.array([(took.clock_s, took.processor_s) for took in of]).mean(axis=0)
        for of in (
            [each.plain_took for each in profile],
            [each.profiled_took for each in profile],
        )
    )
    clock, processor = 100 * (watched / plain - 1)
    return [
        *lines,
        "",
        f"- {watched[0]:.2f} s per episode with the stopwatches, {plain[0]:.2f} s without: "
        f"{clock:+.1f} %; processor time {processor:+.1f} %.",
    ]


def _checks(looks: Sequence[CheckTimes]) -> list[str]:
    lines = [
        f"| one configuration among {BLOCKS} blocks | too near: p50 | p99 | distance: p50 | p99 |",
        "|---|---:|---:|---:|---:|",
    ]
    for each in looks:
        held = "a block in the hand" if each.holds else "nothing in the hand"
        times = [
            f"{1000 * float(np.quantile(of, share)):.2f} ms"
            for of in (each.touches_s, each.free_s)
            for share in (0.5, 0.99)
        ]
        lines.append(f"| {each.where}, {held} | {' | '.join(times)} |")
    every = np.concatenate([of for each in looks for of in (each.touches_s, each.free_s)])
    return [
        *lines,
        "",
        f"- {100 * float((every <= GOAL_S).mean()):.2f} % of {len(every)} checks took at most "
        f"{1000 * GOAL_S:.0f} ms of processor time.",
    ]


def write(speed: Speed, folder: Path) -> list[Path]:
    """Writes `speed.csv`, `profile.csv`, `checks.csv`, `speed.md` and `speed.png`."""
    _write_csv(
        folder / "speed.csv",
        SPEED_FIELDS,
        (
            (
                each.title,
                each.count,
                len(each.ended),
                each.sub_goals,
                f"{each.start_s:.3f}",
                f"{each.work_s:.3f}",
                f"{each.episodes_a_minute:.2f}",
                f"{each.sub_goals_a_minute:.2f}",
                each.late,
            )
            for each in speed.throughput
        ),
    )
    of_parts, of_whole = seconds(speed.profile), shares(speed.profile)
    _write_csv(
        folder / "profile.csv",
        PROFILE_FIELDS,
        (
            (
                part,
                f"{of_parts[part]:.6f}",
                # All digits, so that they add up to 1.
                repr(of_whole[part]),
                sum(each.entered[part] for each in speed.profile),
            )
            for part in PARTS
        ),
    )
    _write_csv(
        folder / "checks.csv",
        CHECKS_FIELDS,
        (
            (
                each.where,
                int(each.holds),
                asked,
                len(of),
                *(f"{1000 * float(np.quantile(of, share)):.4f}" for share in (0.5, 0.99, 1.0)),
            )
            for each in speed.looks
            for asked, of in ((TOUCHES, each.touches_s), (FREE, each.free_s))
        ),
    )
    (folder / "speed.md").write_text(text(speed) + "\n", encoding="utf-8")
    draw(speed, folder / "speed.png")
    names = ("speed.md", "speed.csv", "profile.csv", "checks.csv", "speed.png")
    return [folder / name for name in names]


def _write_csv(path: Path, fields: Sequence[str], rows: Iterable[tuple[object, ...]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(fields)
        writer.writerows(rows)


def draw(speed: Speed, path: Path) -> None:
    """Plots the throughput, where the time goes, and the times of checks, as a PNG."""
    figure, (by_whom, parts, looks) = plt.subplots(1, 3, figsize=(14.0, 4.4), layout="constrained")
    titles = [each.title for each in speed.throughput]
    bars = by_whom.bar(titles, [each.episodes_a_minute for each in speed.throughput])
    by_whom.bar_label(bars, fmt="%.1f")
    by_whom.set(title="trials of the arm", ylabel="episodes per minute")
    by_whom.tick_params(axis="x", labelsize=8)
    of_whole = shares(speed.profile)
    order = sorted(PARTS, key=lambda part: of_whole[part], reverse=True)
    bars = parts.barh([PARTS[part] for part in order], [100 * of_whole[part] for part in order])
    parts.bar_label(bars, fmt="%.1f", padding=2, fontsize=8)
    parts.set(title="where the time of one process goes", xlabel="percent")
    parts.tick_params(axis="y", labelsize=8)
    parts.margins(x=0.12)
    parts.invert_yaxis()
    for each in speed.looks:
        style = "--" if each.holds else "-"
        color = "tab:blue" if each.where == speed.looks[0].where else "tab:orange"
        held = "a block in the hand" if each.holds else "nothing in the hand"
        _tail(looks, each.touches_s, f"{each.where},\n{held}", style, color)
    looks.axvline(1000 * GOAL_S, c="black", lw=1, label="goal")
    looks.set(
        title=f"one check, too near: {BLOCKS} blocks",
        xlabel="milliseconds",
        ylabel="share that takes longer",
        yscale="log",
    )
    # From zero, so that the distance to the goal shows.
    looks.set_xlim(left=0.0)
    looks.grid(alpha=0.3)
    looks.legend(fontsize=7, loc="upper right", bbox_to_anchor=(0.94, 1.0))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _tail(axis: Axes, of_s: NDArray[np.float64], label: str, style: str, color: str) -> None:
    # No sample is longer than the last one, and zero has no logarithm.
    longer = 1.0 - np.arange(1, len(of_s)) / len(of_s)
    axis.step(1000 * np.sort(of_s)[:-1], longer, style, color=color, label=label, where="post")
