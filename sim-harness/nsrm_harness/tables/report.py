"""The report: Markdown with its plots and CSV files beside it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from statistics import fmean, pstdev

import nsrm

from nsrm_harness.domain import Domain
from nsrm_harness.refusals.figure import draw_report
from nsrm_harness.refusals.measure import COLUMNS, KindCount, Report
from nsrm_harness.tables import paper
from nsrm_harness.tables.actions import draw_actions
from nsrm_harness.tables.compare import BEFORE, Comparison, Cost
from nsrm_harness.tables.concepts import draw_concepts
from nsrm_harness.tables.failures import draw_failures, worst_episodes
from nsrm_harness.tables.figures import draw_comparison, draw_steps
from nsrm_harness.tables.results import MEASURES, Row, select, summarize, write_records, write_rows
from nsrm_harness.tables.run import Outcome
from nsrm_harness.tables.study import FAMILIES, JUDGED, QUICK, Study
from nsrm_harness.tables.variants import DISTURBED, EXACT, SAMPLED, VARIED
from nsrm_harness.tables.variants import JUDGED as COMPARED

REPORT = "README.md"
TABLES = "tables.csv"
REFUSALS = "refusals.csv"
COMPARISON = "comparison.csv"
"""Variants and disturbed scenes, with the columns of the tables."""
COSTS = "costs.csv"
HEADINGS = ("program", "O1", "O2", "IoU-2D", "IoU-3D")
TITLES = {
    "train": "training episodes, 1-2 steps",
    "test": "test, 1-2 steps",
    "novel_pairs": "attribute pairs never seen in training",
    "steps_3": "3 steps, trained on 1-2",
    "steps_4": "4 steps",
    "steps_5": "5 steps",
    "steps_6": "6 steps",
    "steps_8": "8 steps",
    "multi_attribute": "two attributes in each description, trained on one",
    "objects_10": "10 objects, trained on 4-6",
    "paraphrase": "orders of words never heard in training",
}


def write_report(
    outcome: Outcome,
    study: Study,
    domain: Domain,
    folder: Path,
    comparison: Comparison | None = None,
) -> None:
    """`README.md`, its pictures, `tables.csv` and `refusals.csv`; with a comparison its files."""
    folder.mkdir(parents=True, exist_ok=True)
    write_rows(folder / TABLES, outcome.rows)
    _write_refusals(folder / REFUSALS, outcome.refusals)
    draw_steps(outcome.rows, folder / "steps.png")
    model = nsrm.Model.load(outcome.model)
    draw_actions(model, domain, folder / "actions.png")
    draw_concepts(outcome.model, outcome.episodes, folder / "concepts.png")
    worst = worst_episodes(model, outcome.episodes)
    draw_failures(worst, outcome.episodes, folder / "failures.png")
    for report in outcome.refusals:
        draw_report(report, folder / f"refusals-{report.set}.png")
    if comparison is not None:
        disturbed = [row for _, rows in comparison.disturbed for row in rows]
        write_rows(folder / COMPARISON, [*comparison.rows, *disturbed])
        write_records(folder / COSTS, [field.name for field in fields(Cost)], comparison.costs)
        draw_comparison(comparison, outcome.rows, study, folder / "comparison.png")
    (folder / REPORT).write_text(markdown(outcome, study, comparison), encoding="utf-8")


def markdown(outcome: Outcome, study: Study, comparison: Comparison | None = None) -> str:
    """The text of the report."""
    *of_paper, beyond, with_detector = tables_of(outcome.rows)
    sections = [
        "# Report",
        _origin(outcome, study),
        "## The paper's tables",
        "Percent, mean over the seeds, in brackets the least and the greatest. The paper's own "
        "figures are for its own data.",
        *of_paper,
        "## Beyond them",
        beyond,
        "![accuracy against steps](steps.png)",
        "## Boxes from the detector",
        "The same models and episodes; boxes and depths come from the detector on colour and "
        "depth in place of the simulator's mask.",
        with_detector,
        "## Refusals",
        *(part for report in outcome.refusals for part in _refusals(report)),
        *(_comparison(comparison) if comparison is not None else []),
        "## What was learned",
        f"The model of seed {study.seeds[0]}. Each action, over a grid of references (grey): where "
        "the block comes to stand (dot, its height in colour), and the mean and deviation of the "
        "way from the reference's centre. The scenes never said which action is which.",
        "![each action on a grid](actions.png)",
        "Concepts of different attribute types are in different spaces: only cosines between the "
        "black lines mean something.",
        "![concepts and blocks](concepts.png)",
        "## The worst episodes",
        "Of the test episodes with the boxes of the mask, the worst first.",
        "![the worst episodes](failures.png)",
    ]
    return "\n\n".join(sections) + "\n"


def tables_of(rows: Sequence[Row]) -> list[str]:
    """The paper's tables, those beyond them, and those with the detector's boxes."""
    return [
        *(_paper_table(rows, split) for split in JUDGED if split in paper.TABLES),
        _table(rows, [split for split in JUDGED if split not in paper.TABLES], "mask"),
        _table(rows, JUDGED, "detector"),
    ]


def _origin(outcome: Outcome, study: Study) -> str:
    seeds = ", ".join(map(str, study.seeds))
    families = "; ".join(
        f"{family.train}: {study.settings(family.train).count}" for family in FAMILIES
    )
    return (
        f"Written by `cargo harness tables{' --quick' if study.name == QUICK else ''}` at "
        f"{_commits(outcome.commits)}; seeds of the models {seeds}, of the data {study.data_seed}; "
        f"episodes for training: {families}. Models are judged through the Rust core alone; a "
        "refused sentence counts as wrong in every measure. The baseline is told where the "
        "steps of a sentence end."
    )


def _commits(commits: Sequence[str]) -> str:
    return f"commit{'s' if len(commits) > 1 else ''} {', '.join(commits)}"


def _paper_table(rows: Sequence[Row], split: str) -> str:
    lines = [f"### Table {paper.TABLES[split]}", "", _header("")]
    for model, name in (("baseline", "baseline"), ("nsrm", "model")):
        figures = paper.ROWS[split, model]
        cells = [_number(getattr(figures, measure)) for measure in MEASURES]
        lines.append(_line(f"paper, {name}", cells))
    for model, name in (("baseline", "baseline"), ("nsrm", "**NSRM**")):
        lines.append(_line(f"ours, {name}", _cells(select(rows, split, model, "mask"))))
    return "\n".join(lines)


def _table(rows: Sequence[Row], splits: Iterable[str], boxes: str) -> str:
    lines = [_header("split")]
    for split in splits:
        for model, name in (("nsrm", ""), ("baseline", ", baseline")):
            if chosen := select(rows, split, model, boxes):
                lines.append(_line(TITLES[split] + name, _cells(chosen)))
    return "\n".join(lines)


def _cells(rows: Sequence[Row]) -> list[str]:
    cells = []
    for measure in MEASURES:
        summary = summarize(rows, measure)
        if summary is None:
            cells.append("-")
        elif len(rows) == 1:
            cells.append(_number(summary.mean))
        else:
            cells.append(f"{summary.mean:.1f} ({summary.least:.1f}-{summary.greatest:.1f})")
    return cells


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def _header(first: str) -> str:
    return _line(first, HEADINGS) + "\n|---|" + "---:|" * len(HEADINGS)


def _line(first: str, cells: Iterable[str]) -> str:
    return f"| {first} | " + " | ".join(cells) + " |"


def _refusals(report: Report) -> list[str]:
    lines = ["| what is wrong | sentences | refused | accepted |", "|---|---:|---:|---:|"]
    for kind in report.kinds:
        name = kind.kind.replace("_", " ")
        lines.append(f"| {name} | {kind.count} | {kind.refused} | {kind.wrongly_accepted} |")
    bad = sum(kind.count for kind in report.kinds)
    refused = sum(kind.refused for kind in report.kinds)
    good = sum(report.refused.values())
    lines.append(f"| all | {bad} | {refused} | {bad - refused} |")
    return [
        f"### On {report.set}",
        "\n".join(lines),
        f"Of what must be refused {refused / bad:.2%} was. Of {report.good} good sentences "
        f"{report.right / report.good:.2%} were planned rightly and {good / report.good:.2%} "
        f"refused.",
        f"![risk against coverage, and calibration](refusals-{report.set}.png)",
    ]


def _comparison(comparison: Comparison) -> list[str]:
    models = list(dict.fromkeys(row.model for row in comparison.rows))
    seconds = {
        name: sum(cost.seconds for cost in comparison.costs if cost.variant == name)
        for name in models
    }
    headings = [f"{name}, {split}" for split in COMPARED for name in ("program", "IoU-3D")]
    lines = [_line("trained otherwise", [*headings, "seeds", "minutes"])]
    lines.append("|---|" + "---:|" * (len(headings) + 2))
    for name in models:
        cells, count = [], 0
        for split in COMPARED:
            chosen = select(comparison.rows, split, name, "mask")
            program, _, _, _, volume = _cells(chosen)
            cells += [program, volume]
            count = len(chosen)
        minutes = f"{seconds[name] / count / 60:.1f}" if seconds[name] else ""
        lines.append(_line(name, [*cells, str(count), minutes]))
    merged = ", ".join(f"{name} (seed {seed})" for name, seed in comparison.merged)
    return [
        "## What the parts are worth",
        "The same data, one thing changed in each row; minutes of one processor a seed. Mean over "
        "the seeds, in brackets the least and the greatest.",
        "\n".join(lines),
        *([f"Two actions were learned as one by: {merged}."] if merged else []),
        *_reinforce(comparison),
        "## Disturbed scenes, and how much data",
        "The same scenes whatever the size. At the size 1 the camera stands up to "
        f"{VARIED.camera_m * 1e3:.0f} mm beside its place along each axis and is turned by up to "
        f"{VARIED.camera_deg:g}°, light is off by up to {VARIED.light:.0%}, colours by up to "
        f"{VARIED.color:.0%}, and depth has noise of {VARIED.depth_m * 1e3:.0f} mm.",
        "![accuracy against disturbance and data](comparison.png)",
        _disturbed_table(comparison),
    ]


def _reinforce(comparison: Comparison) -> list[str]:
    """How near the sampled splitter comes to the exact one, seed by seed."""
    told = []
    for exact, sampled, when in (
        (EXACT, SAMPLED, "In the end"),
        (EXACT + BEFORE, SAMPLED + BEFORE, "Before the last stage, which teaches the splitter too"),
    ):
        for split in COMPARED:
            means = [
                summarize(select(comparison.rows, split, name, "mask"), "program")
                for name in (exact, sampled)
            ]
            own = select(comparison.rows, split, sampled, "mask")
            if means[0] is None or means[1] is None:
                continue
            near = sum(abs((row.program or 0.0) - means[0].mean) <= 1.0 for row in own)
            deviations = [
                pstdev(row.program or 0.0 for row in select(comparison.rows, split, name, "mask"))
                for name in (exact, sampled)
            ]
            told.append(
                f"{when}, {TITLES[split]}: {near} of {len(own)} seeds are within 1 point of the "
                f"exact expectation's mean; deviation over the seeds {deviations[0]:.2f} exact, "
                f"{deviations[1]:.2f} sampled."
            )
    if not told:
        return []
    costs = {
        name: fmean(
            sum(c.seconds for c in comparison.costs if (c.variant, c.seed) == (name, seed))
            for seed in sorted({c.seed for c in comparison.costs if c.variant == name})
        )
        for name in (EXACT, SAMPLED)
    }
    ratio = costs[SAMPLED] / costs[EXACT]
    items = "\n".join(f"- {line}" for line in told)
    return [f"REINFORCE takes {ratio:.2f} times as long.\n\n{items}"]


def _disturbed_table(comparison: Comparison) -> str:
    models = list(dict.fromkeys(row.model for _, rows in comparison.disturbed for row in rows))
    lines = [_line(DISTURBED, [f"{HEADINGS[0]}, {m} | {HEADINGS[-1]}, {m}" for m in models])]
    lines.append("|---|" + "---:|" * (2 * len(models)))
    for each, rows in comparison.disturbed:
        cells: list[str] = []
        for model in models:
            program, _, _, _, volume = _cells([row for row in rows if row.model == model])
            cells += [program, volume]
        name = each.kind if each.size == 0.0 else f"{each.kind}, {each.size:g}"
        lines.append(_line(name, cells))
    return "\n".join(lines)


def _write_refusals(path: Path, reports: Sequence[Report]) -> None:
    kinds: list[KindCount] = [kind for report in reports for kind in report.kinds]
    write_records(path, COLUMNS, kinds)
