"""Reports the results of the figures' variations: a Markdown table and files."""

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
"""Share of a figure's variations that must succeed."""


def text(ended: Sequence[VariationResult]) -> str:
    """A Markdown table for people, and the reason of each variation that did not succeed."""
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
        f"- Steps with an unexpected contact of the arm or its block: {touched}.",
    ]
    others = [each for each in ended if each.end != "succeeded"]
    lines += [
        f"- figure {each.figure}, variation {each.variation}: {each.end}: {each.why}"
        for each in others
    ]
    return "\n".join(lines)


def missed(ended: Sequence[VariationResult]) -> list[str]:
    """Lists the figures that do significantly worse than `GOAL`, and unexpected contacts."""
    found = []
    for number, variations, succeeded, *_ in _rows(ended):
        if is_worse(succeeded, variations, GOAL):
            found.append(
                f"figure {number}: {succeeded} of {variations} succeeded, "
                f"the goal is {100 * GOAL:.1f} %"
            )
        done = [done for each in ended if each.figure == number for done in each.steps]
        if touched := sorted({pair for each in done for pair in each.verdict.touched}):
            found.append(f"figure {number}: unexpected contact: {', '.join(touched)}")
    return found


def write_csv(ended: Sequence[VariationResult], path: Path) -> None:
    """Writes one line per figure: how many variations ended in each way."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("figure", "variations", *ENDS))
        writer.writerows(_rows(ended))


def write_jsonl(ended: Sequence[VariationResult], path: Path) -> None:
    """Writes one line per episode."""
    lines = [json_text(asdict(each), ensure_ascii=False) + "\n" for each in ended]
    path.write_text("".join(lines), encoding="utf-8")


def _rows(ended: Sequence[VariationResult]) -> list[tuple[int, ...]]:
    rows = []
    for number in sorted({each.figure for each in ended}):
        counts = Counter(each.end for each in ended if each.figure == number)
        rows.append((number, counts.total(), *(counts[end] for end in ENDS)))
    return rows
