"""What the variations came to: for people, and as files."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from nsrm_harness.common.json_text import json_text
from nsrm_harness.evaluation.manipulation_trials.confidence_interval import is_worse
from nsrm_harness.paper.figures.run_figures import VariationResult
from nsrm_harness.paper.figures.scenes import FIGURES

ENDS = ("succeeded", "refused", "failed")
GOAL = 0.98
"""Share of a figure's variations that is to succeed."""


def text(ended: Sequence[VariationResult]) -> str:
    """A table in Markdown, and why what did not succeed did not."""
    lines = [
        "| figure | sentence | variations | succeeded | refused | failed |",
        "|---:|---|---:|---:|---:|---:|",
    ]
    sentences = {figure.number: figure.sentence for figure in FIGURES}
    for number, *counts in _rows(ended):
        lines.append(f"| {number} | {sentences[number]} | {' | '.join(map(str, counts))} |")
    touched = sum(bool(done.verdict.touched) for each in ended for done in each.steps)
    lines += [
        "",
        f"- Steps in which the arm or its block touched what it should not have: {touched}.",
    ]
    others = [each for each in ended if each.end != "succeeded"]
    lines += [
        f"- figure {each.figure}, variation {each.variation}: {each.end}: {each.why}"
        for each in others
    ]
    return "\n".join(lines)


def missed(ended: Sequence[VariationResult]) -> list[str]:
    """Figures that do worse than chance allows of an arm that reaches `GOAL`, and contacts that
    nothing had foreseen."""
    found = []
    for number, variations, succeeded, *_ in _rows(ended):
        if is_worse(succeeded, variations, GOAL):
            found.append(
                f"figure {number}: {succeeded} of {variations} done as said, "
                f"{100 * GOAL:.1f} % is the goal"
            )
        done = [done for each in ended if each.figure == number for done in each.steps]
        if touched := sorted({pair for each in done for pair in each.verdict.touched}):
            found.append(f"figure {number}: not foreseen: {', '.join(touched)} touched")
    return found


def write_csv(ended: Sequence[VariationResult], path: Path) -> None:
    """A line a figure: how many variations ended how."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("figure", "variations", *ENDS))
        writer.writerows(_rows(ended))


def write_jsonl(ended: Sequence[VariationResult], path: Path) -> None:
    """A line an episode."""
    lines = [json_text(asdict(each), ensure_ascii=False) + "\n" for each in ended]
    path.write_text("".join(lines), encoding="utf-8")


def _rows(ended: Sequence[VariationResult]) -> list[tuple[int, ...]]:
    rows = []
    for number in sorted({each.figure for each in ended}):
        counts = Counter(each.end for each in ended if each.figure == number)
        rows.append((number, counts.total(), *(counts[end] for end in ENDS)))
    return rows
