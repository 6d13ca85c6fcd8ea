"""What the variations came to: for people, and as files."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from nsrm_harness.figures.scenes import FIGURES
from nsrm_harness.figures.show import Ended

ENDS = ("succeeded", "refused", "failed")


def text(ended: Sequence[Ended]) -> str:
    """A table in Markdown, and why what did not succeed did not."""
    lines = [
        "| figure | sentence | variations | succeeded | refused | failed |",
        "|---:|---|---:|---:|---:|---:|",
    ]
    sentences = {figure.number: figure.sentence for figure in FIGURES}
    for number, *counts in _rows(ended):
        lines.append(f"| {number} | {sentences[number]} | {' | '.join(map(str, counts))} |")
    others = [each for each in ended if each.end != "succeeded"]
    if others:
        lines.append("")
    lines += [
        f"- figure {each.figure}, variation {each.variation}: {each.end}: {each.why}"
        for each in others
    ]
    return "\n".join(lines)


def write_csv(ended: Sequence[Ended], path: Path) -> None:
    """A line a figure: how many variations ended how."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("figure", "variations", *ENDS))
        writer.writerows(_rows(ended))


def write_jsonl(ended: Sequence[Ended], path: Path) -> None:
    """A line an episode."""
    lines = [json.dumps(asdict(each), ensure_ascii=False) + "\n" for each in ended]
    path.write_text("".join(lines), encoding="utf-8")


def _rows(ended: Sequence[Ended]) -> list[tuple[int, ...]]:
    rows = []
    for number in sorted({each.figure for each in ended}):
        counts = Counter(each.end for each in ended if each.figure == number)
        rows.append((number, counts.total(), *(counts[end] for end in ENDS)))
    return rows
