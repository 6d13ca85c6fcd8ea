"""Publishes a report into the project: the report itself, the model, and the README's figures."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.paper.tables.lines import HEADINGS, TITLES
from nsrm_harness.paper.tables.published_figures import ROWS, TABLES
from nsrm_harness.paper.tables.results import MEASURES, ResultRow, read_rows, select, summarize
from nsrm_harness.paper.tables.study import JUDGED
from nsrm_harness.paper.tables.tables_report import REFUSAL_COLUMNS, REFUSALS
from nsrm_harness.paper.tables.tables_report import TABLES as TABLES_FILE

BEGIN = "<!-- figures: `cargo harness publish` replaces them -->"
END = "<!-- end of figures -->"
REPORT_FOLDER = Path("docs/report")
LANGUAGE = "language.csv"
README = Path("README.md")
MODEL = Path("weights-codegen/tabletop/tabletop.safetensors")


class PublishError(HarnessError):
    """A report or a README that cannot be used for publishing."""


def publish(report: Path, model: Path, root: Path) -> None:
    """Copy the report's files and the model into the checkout at `root`; update its README."""
    for needed in (report / TABLES_FILE, report / REFUSALS, model):
        if not needed.exists():
            raise PublishError(f"{needed}: not found: create it with 'harness tables'")
    text = with_figures((root / README).read_text(encoding="utf-8"), report)
    target = root / REPORT_FOLDER
    # Its folders are other reports, and so is what `harness language` writes.
    for old in target.glob("*"):
        if old.is_file() and old.name != LANGUAGE:
            old.unlink()
    shutil.copytree(report, target, dirs_exist_ok=True)
    shutil.copyfile(model, root / MODEL)
    (root / README).write_text(text, encoding="utf-8")


def with_figures(readme: str, report: Path) -> str:
    """The README with the figures of a report between its two markers."""
    before, begin, rest = readme.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise PublishError(f"README: the markers of the figures are missing: {BEGIN!r} and {END!r}")
    block = figures(read_rows(report / TABLES_FILE), _refusals(report / REFUSALS))
    return f"{before}{BEGIN}\n{block}\n{END}{after}"


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
