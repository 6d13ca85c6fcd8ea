"""Writes the report: Markdown with its plots and CSV files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from pathlib import Path

import nsrm

from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.refusals.measure import COLUMNS
from nsrm_harness.evaluation.refusals.plot import draw_report
from nsrm_harness.paper.tables import published_figures as paper
from nsrm_harness.paper.tables.actions import draw_actions
from nsrm_harness.paper.tables.compare import Comparison, Cost
from nsrm_harness.paper.tables.concepts import draw_concepts
from nsrm_harness.paper.tables.detections import COLUMNS as DETECTOR_COLUMNS
from nsrm_harness.paper.tables.detections import table_of
from nsrm_harness.paper.tables.failures import draw_failures, worst_episodes
from nsrm_harness.paper.tables.lines import TITLES, cells_of, header_of, line_of, number
from nsrm_harness.paper.tables.parts import comparison_sections
from nsrm_harness.paper.tables.plots import draw_comparison, draw_steps
from nsrm_harness.paper.tables.results import MEASURES, ResultRow, select, write_records, write_rows
from nsrm_harness.paper.tables.run_tables import (
    FIRST_MODELS,
    REFUSAL_SETS,
    SeedReport,
    TablesResult,
)
from nsrm_harness.paper.tables.study import FAMILIES, JUDGED, QUICK, Study
from nsrm_harness.paper.tables.times import PartTime

REPORT = "README.md"
TABLES = "tables.csv"
REFUSALS = "refusals.csv"
REFUSAL_COLUMNS: tuple[str, ...] = ("seed", *COLUMNS)
COMPARISON = "comparison.csv"
"""Results for variants and disturbed scenes, with the columns of the tables."""
COSTS = "costs.csv"
DETECTOR = "detector.csv"
TIMES = "times.csv"


def write_report(
    outcome: TablesResult,
    study: Study,
    domain: Domain,
    folder: Path,
    comparison: Comparison | None = None,
) -> None:
    """Writes `README.md`, its plots and CSV files, and those of a comparison, if any."""
    folder.mkdir(parents=True, exist_ok=True)
    write_rows(folder / TABLES, outcome.rows)
    write_records(folder / DETECTOR, DETECTOR_COLUMNS, outcome.detections)
    write_records(folder / TIMES, [field.name for field in fields(PartTime)], outcome.times)
    _write_refusals(folder / REFUSALS, outcome.refusals)
    draw_steps(outcome.rows, folder / "steps.png")
    model = nsrm.Model.load(outcome.model)
    draw_actions(model, domain, folder / "actions.png")
    draw_concepts(outcome.model, outcome.episodes, folder / "concepts.png")
    worst = worst_episodes(model, outcome.episodes)
    draw_failures(worst, outcome.episodes, folder / "failures.png")
    for of_seed in outcome.refusals:
        if of_seed.seed == study.seeds[0]:
            draw_report(of_seed.report, folder / f"refusals-{of_seed.report.set}.png")
    if comparison is not None:
        disturbed = [row for _, rows in comparison.disturbed for row in rows]
        write_rows(folder / COMPARISON, [*comparison.rows, *disturbed])
        write_records(folder / COSTS, [field.name for field in fields(Cost)], comparison.costs)
        draw_comparison(comparison, outcome.rows, study, folder / "comparison.png")
    (folder / REPORT).write_text(markdown(outcome, study, comparison), encoding="utf-8")


def markdown(outcome: TablesResult, study: Study, comparison: Comparison | None = None) -> str:
    """The report as Markdown."""
    *of_paper, beyond, with_detector = tables_of(outcome.rows)
    sections = [
        "# Report",
        _origin(outcome, study),
        "## The paper's tables",
        "Percent: the mean over the seeds, with the lowest and highest in brackets. The paper's "
        "figures are for its own data.",
        *of_paper,
        "## Beyond the paper's tables",
        beyond,
        "![accuracy against steps](steps.png)",
        "## Boxes from the detector",
        "The same models and episodes; boxes and depths come from the detector on colour and "
        "depth instead of the simulator's mask.",
        with_detector,
        "The detections compared with the mask's boxes; where depth has noise, one pixel in a "
        "hundred has no depth. Errors are those of the mean depth and of the box's centre at that "
        "depth, in the world; the time is the median on one core.",
        table_of(outcome.detections),
        "## Refusals",
        *(part for name in REFUSAL_SETS for part in _refusals(name, outcome.refusals)),
        *(comparison_sections(comparison) if comparison is not None else []),
        "## What was learned",
        f"The model of seed {study.seeds[0]}. Each action, over a grid of references (grey): where "
        "the block is placed (dot, its height in colour), and the mean and standard deviation of "
        "its offset from the reference's centre. The scenes never showed the names of the "
        "actions.",
        "![each action on a grid](actions.png)",
        "Concepts of different attribute types are in different spaces: only cosines within the "
        "black lines are meaningful.",
        "![concepts and blocks](concepts.png)",
        "## The worst episodes",
        "The worst of the test episodes with the mask's boxes, worst first.",
        "![the worst episodes](failures.png)",
        "## How long it took",
        _times(outcome.times, outcome.processes),
    ]
    return "\n\n".join(sections) + "\n"


def tables_of(rows: Sequence[ResultRow]) -> list[str]:
    """The paper's tables, the splits beyond them, and the splits with the detector's boxes."""
    return [
        *(_paper_table(rows, split) for split in JUDGED if split in paper.TABLES),
        _table(rows, [split for split in JUDGED if split not in paper.TABLES], "mask"),
        _table(rows, JUDGED, "detector"),
    ]


def _origin(outcome: TablesResult, study: Study) -> str:
    seeds = ", ".join(map(str, study.seeds))
    families = "; ".join(
        f"{family.train}: {study.settings(family.train).count}" for family in FAMILIES
    )
    return (
        f"Written by `cargo harness tables{' --quick' if study.name == QUICK else ''}` at "
        f"{_commits(outcome.commits)}; model seeds {seeds}; data seed {study.data_seed}; "
        f"training episodes: {families}. Models are judged only through the Rust core; a refused "
        "sentence counts as wrong in every measure. The baseline is told where the steps of a "
        "sentence end."
    )


def _times(times: Sequence[PartTime], processes: int) -> str:
    whole = sum(took.seconds for took in times if took.part != FIRST_MODELS)
    parts = [(took.part, took.seconds) for took in times]
    lines = ["| part | minutes |", "|---|---:|"]
    lines += [f"| {part} | {s / 60:.1f} |" for part, s in [*parts, ("total", whole)]]
    return (
        f"Wall time with {processes} processes, summed over all calls if it was interrupted; plots "
        "and variants are not counted.\n\n" + "\n".join(lines)
    )


def _commits(commits: Sequence[str]) -> str:
    return f"commit{'s' if len(commits) > 1 else ''} {', '.join(commits)}"


def _paper_table(rows: Sequence[ResultRow], split: str) -> str:
    lines = [f"### Table {paper.TABLES[split]}", "", header_of("")]
    for model, name in (("baseline", "baseline"), ("nsrm", "model")):
        figures = paper.ROWS[split, model]
        cells = [number(getattr(figures, measure)) for measure in MEASURES]
        lines.append(line_of(f"paper, {name}", cells))
    for model, name in (("baseline", "baseline"), ("nsrm", "**NSRM**")):
        lines.append(line_of(f"ours, {name}", cells_of(select(rows, split, model, "mask"))))
    return "\n".join(lines)


def _table(rows: Sequence[ResultRow], splits: Iterable[str], boxes: str) -> str:
    lines = [header_of("split")]
    for split in splits:
        for model, name in (("nsrm", ""), ("baseline", ", baseline")):
            if chosen := select(rows, split, model, boxes):
                lines.append(line_of(TITLES[split] + name, cells_of(chosen)))
    return "\n".join(lines)


def _refusals(which: str, every: Sequence[SeedReport]) -> list[str]:
    """The section on a set: how many sentences of each kind each seed's model refuses."""
    of_set = [each for each in every if each.report.set == which]
    if not of_set:
        return []
    seeds = [f"seed {each.seed} refused" for each in of_set]
    lines = [
        f"| fault | sentences | {' | '.join(seeds)} |",
        "|---|" + "---:|" * (1 + len(of_set)),
    ]
    for rows in zip(*(each.report.kinds for each in of_set), strict=True):
        name = rows[0].kind.replace("_", " ")
        refused = " | ".join(str(row.refused) for row in rows)
        lines.append(f"| {name} | {rows[0].count} | {refused} |")
    reports = [each.report for each in of_set]
    bad = sum(kind.count for report in reports for kind in report.kinds)
    refused = sum(kind.refused for report in reports for kind in report.kinds)
    good, right = (sum(getattr(report, name) for report in reports) for name in ("good", "right"))
    lost = sum(sum(report.refused.values()) for report in reports)
    return [
        f"### On {which}",
        "\n".join(lines),
        f"{refused / bad:.2%} of the sentences that must be refused were refused. Of {good} good "
        f"sentences {right / good:.2%} were planned correctly and {lost / good:.2%} refused.",
        f"![risk against coverage, and calibration](refusals-{which}.png)",
    ]


def _write_refusals(path: Path, every: Sequence[SeedReport]) -> None:
    rows = [{"seed": each.seed} | asdict(kind) for each in every for kind in each.report.kinds]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, REFUSAL_COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
