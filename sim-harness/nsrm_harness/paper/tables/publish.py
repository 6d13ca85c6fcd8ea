"""Publishes a report into the project: the report itself, and the README's figures."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.marked_text import replaced
from nsrm_harness.evaluation import language
from nsrm_harness.paper.tables.lines import HEADINGS, TITLES
from nsrm_harness.paper.tables.published_figures import ROWS, TABLES
from nsrm_harness.paper.tables.results import MEASURES, ResultRow, read_rows, select, summarize
from nsrm_harness.paper.tables.study import JUDGED
from nsrm_harness.paper.tables.tables_report import REFUSAL_COLUMNS, REFUSALS
from nsrm_harness.paper.tables.tables_report import TABLES as TABLES_FILE

BEGIN = "<!-- figures: `cargo harness publish` replaces them -->"
END = "<!-- end of figures -->"
BEGIN_LANGUAGE = "<!-- language: `cargo harness publish --readme-only` replaces it -->"
END_LANGUAGE = "<!-- end of language -->"
REPORT_FOLDER = Path("docs/report")
LANGUAGE = "language.csv"
SETS = {
    "test": "test, in the grammar that the paper's training uses",
    "test; misspelt": "the same, one word misspelt",
    "test; everyday wording": "the same programs in everyday wording",
    "test; everyday wording held out": "the same, in patterns kept from training",
    "mixed; 1 step": "all kinds of descriptions, one step",
    "mixed; 2 steps": "the same, two steps",
    "mixed; 3 steps": "the same, three steps",
    "mixed; 5 steps": "the same, five steps",
    "several": 'several objects: "all red blocks", "both of the small ones"',
    "several held out": "the same, in patterns kept from training",
    "several references": "several references; to refuse",
    "exceptions": '"all blocks except the red one", "the block that is not red"',
    "no exceptions": "such that leave nothing out that is meant; to refuse",
    "several in scenes": "several objects, in their scenes",
    "several in scenes with stacks": "the same where blocks hide others in part",
    "several of another number": "of none, or not two, in the scene; to refuse",
    "exceptions in scenes": "several objects except one, in their scenes",
    "exceptions in scenes with stacks": "the same where blocks hide others in part",
    "exceptions of another number": "except one of which there is none, or several; to refuse",
    "values apart": 'values that stand apart: "the small block that is red"',
    "values apart of one type": "two values of one type; to refuse",
    "other phrases": '"the red block is supposed to be on …", "put it so that it is left of …"',
    "no orders": "such that order nothing, to refuse",
    "wordy": 'with words that change nothing: "um, so, could you please …"',
    "no wordy orders": "such that order nothing, to refuse",
    "points of view": '"from the robot\'s point of view, …"',
    "no points of view": "that of nobody; to refuse",
    "lists": 'lists: "the red and the blue block on the green one"',
    "no lists": "such that list nothing that can be moved, to refuse",
    "between": '"between the red and the blue block"',
    "not between": "such that nobody can do, to refuse",
    "between in scenes": "between two other blocks, in their scenes: where there is room",
    "repairs": '"the red block, no, the green one", "the red one, not the green one"',
    "no repairs": "such of which nobody can tell what is meant, to refuse",
    "order of time": 'two steps in another order: "before you put the red block on …, put …"',
    "no order of time": "such whose steps have no order, to refuse",
    "ordinals": '"the second red block from the left", "the third biggest one"',
    "no ordinals": "such that count nothing, to refuse",
    "ordinals in scenes": "ordinals, in the scenes that they are about",
    "ordinals of none or several": "of which there are too few or which are not clear, to refuse",
    "towers and rows": '"build a tower of red, green and blue", "put all small blocks in a row"',
    "no towers and rows": "such that mean none, to refuse",
    "on the table": 'the table: "put the red block on the table", "take it off the blue one"',
    "not on the table": "such that nobody can do, to refuse",
    "on the table in scenes": "from other blocks to the table, in their scenes",
    "on the table already": "of those that stand there already; to refuse",
    "next to and diagonally": '"next to the blue block", "in front and to the left of it"',
    "not next to": "such that nobody can do, to refuse",
    "next to in scenes": "next to another block, in their scenes: where there is room",
    "diagonally in scenes": "diagonally from another block, in their scenes",
    "distances": '"two centimetres to the left of the blue block", "5 cm from it"',
    "no distances": "such that mean none, to refuse",
    "shifts": '"move the red block 5 cm to the left", from where it is',
    "no shifts": "such that move nothing so, to refuse",
    "distances in scenes": "a named distance to a side, in their scenes: where there is room",
    "shifts in scenes": "a distance from where a block is, in its scene: where there is room",
    "pronouns": 'pronouns: "… and put the green block on it"',
    "pronouns held out": "the same, in patterns kept from training",
    "pronouns of nothing": "pronouns that mean nothing; to refuse",
    "relations": 'relations in descriptions: "the block left of the red one"',
    "relations held out": "the same, in patterns kept from training",
    "relations in scenes": "the same in their scenes: the right blocks",
    "relations of none or several": "in scenes where they hold for none or several; to refuse",
    "relations with two readings": "relations that may belong to either description, to refuse",
    "superlatives": 'nearest and farthest: "the block nearest to the white one"',
    "superlatives held out": "the same, in patterns kept from training",
    "superlatives in scenes": "the same in their scenes: the right blocks",
    "superlatives of none or several": "in scenes where none or several are meant; to refuse",
    "superlatives with two readings": "those that may belong to either description, to refuse",
    "extremes": 'which one of several: "the leftmost red block", "the biggest one"',
    "extremes held out": "the same, in patterns kept from training",
    "extremes in scenes": "the same in their scenes: the right blocks",
    "extremes of none or several": "in scenes where no one is clearly meant; to refuse",
    "near misses": "near misses, all of known words; to refuse",
    "sentences": "other people's sentences",
    "sentences; to refuse": "other people's sentences, to refuse",
    "sentences; to refuse; misspelt": "the same, one word misspelt",
    "probes": 'other people\'s sentences like "put the block left of the red one on …"',
}
"""What the README calls the sets of `language.csv`."""
README = Path("README.md")


class PublishError(HarnessError):
    """A report or a README that cannot be used for publishing."""


def publish(report: Path, root: Path) -> None:
    """Copy the report's files into the checkout at `root`; update its README."""
    for needed in (report / TABLES_FILE, report / REFUSALS):
        if not needed.exists():
            raise PublishError(f"{needed}: not found: create it with 'harness tables'")
    text = with_figures(read_readme(root), report)
    target = root / REPORT_FOLDER
    # Its folders are other reports, and so is what `harness language` writes.
    for old in target.glob("*"):
        if old.is_file() and old.name != LANGUAGE:
            old.unlink()
    shutil.copytree(report, target, dirs_exist_ok=True)
    (root / README).write_text(text, encoding="utf-8")


def update_readme(root: Path) -> None:
    """Update the README of the checkout at `root` with the figures of its own report."""
    report = root / REPORT_FOLDER
    text = with_language(with_figures(read_readme(root), report), report)
    (root / README).write_text(text, encoding="utf-8")


def read_readme(root: Path) -> str:
    """The README of the checkout at `root`."""
    return (root / README).read_text(encoding="utf-8")


def with_figures(readme: str, report: Path) -> str:
    """The README with the figures of a report between its two markers."""
    block = figures(read_rows(report / TABLES_FILE), _refusals(report / REFUSALS))
    return replaced(readme, BEGIN, block, END)


def with_language(readme: str, report: Path) -> str:
    """The README with what the models understand between its two markers."""
    block = understood(language.read_rows(report / LANGUAGE))
    return replaced(readme, BEGIN_LANGUAGE, block, END_LANGUAGE)


def figures(rows: Sequence[ResultRow], refusals: Sequence[dict[str, Any]]) -> str:
    """The README's table (means over the seeds, with the paper's in brackets) and its remarks.

    Splits that the report does not have are left out.
    """
    lines = [f"| | {' | '.join(HEADINGS)} |", "|---|" + "---:|" * len(HEADINGS)]
    for split in JUDGED:
        if split == "train":
            continue
        chosen = select(rows, split, "nsrm", "mask")
        if not chosen:
            continue
        cells = [_cell(split, measure, chosen) for measure in MEASURES]
        table = f" (Table {TABLES[split].split(',')[0]})" if split in TABLES else ""
        lines.append(f"| {TITLES[split]}{table} | {' | '.join(cells)} |")
    seeds = len({row.seed for row in rows})
    least = min(row.episodes for row in rows)
    of_test = [row for row in refusals if row["set"] == "test"]
    kinds = {row["kind"] for row in of_test}
    count, refused = (sum(int(row[name]) for row in of_test) for name in ("count", "refused"))
    return "\n".join(
        [
            *lines,
            "",
            f"Percent, mean of {seeds} {'seed' if seeds == 1 else 'seeds'}, at least {least} "
            "episodes per row; a refusal counts as wrong; in brackets the paper's figures, on its "
            "own data.",
            _with_detector(rows),
            f"Of {count} sentences that must be refused ({len(kinds)} kinds, "
            f"{seeds} {'model' if seeds == 1 else 'models'}), {refused} are.",
        ]
    )


def understood(rows: Sequence[tuple[int, language.Counted]]) -> str:
    """The README's table of sentences: all models of a set together."""
    lines = [
        "| | sentences | understood | refused | taken for something else |",
        "|---|---:|---:|---:|---:|",
    ]
    for name, title in SETS.items():
        chosen = [row for _, row in rows if row.set == name]
        count = sum(row.count for row in chosen)
        if count == 0:
            continue
        right, refused, wrong = (
            f"{100 * sum(getattr(row, measure) for row in chosen) / count:.1f} %"
            for measure in ("right", "refused", "wrong")
        )
        lines.append(f"| {title} | {count} | {right} | {refused} | {wrong} |")
    seeds = len({seed for seed, _ in rows})
    told = f"Means of {seeds} models" if seeds > 1 else "The built-in model"
    scenes = "Sentences are planned in scenes where the table says so, and only parsed elsewhere."
    return "\n".join([*lines, "", f"{told}, through the Rust core. {scenes}"])


def _with_detector(rows: Sequence[ResultRow]) -> str:
    chosen = select(rows, "test", "nsrm", "detector")
    told = [f"{name} {_cell('', m, chosen)}" for name, m in zip(HEADINGS, MEASURES, strict=True)]
    return (
        "With boxes and depths from the detector instead of the simulator's mask, on test: "
        f"{', '.join(told)}."
    )


def _cell(split: str, measure: str, rows: Sequence[ResultRow]) -> str:
    summary = summarize(rows, measure)
    if summary is None:
        return "-"
    told = ROWS.get((split, "nsrm"))
    paper = f" ({getattr(told, measure):.1f})" if told else ""
    return f"{summary.mean:.1f}{paper}"


def _refusals(path: Path) -> list[dict[str, Any]]:
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != REFUSAL_COLUMNS:
            raise PublishError(f"{path}: expected the columns {','.join(REFUSAL_COLUMNS)}")
        return list(reader)
