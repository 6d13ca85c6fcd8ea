"""The tables: figures to files and back, the report's text, the README's figures."""

from __future__ import annotations

import json
import time
from dataclasses import asdict
from pathlib import Path

import pytest
from PIL import Image

from nsrm_harness import domain as domains
from nsrm_harness.common.marked_text import MarkError
from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.evaluation import language
from nsrm_harness.evaluation.metrics import EvaluationError, Metrics
from nsrm_harness.paper.tables.compare import BEFORE, Comparison, Cost
from nsrm_harness.paper.tables.detections import COLUMNS, DetectorRow, table_of
from nsrm_harness.paper.tables.lines import TITLES
from nsrm_harness.paper.tables.plots import draw_comparison
from nsrm_harness.paper.tables.publish import (
    BEGIN,
    BEGIN_LANGUAGE,
    END,
    END_LANGUAGE,
    README,
    PublishError,
    publish,
    with_figures,
    with_language,
)
from nsrm_harness.paper.tables.results import (
    ResultRow,
    ResultsError,
    Summary,
    read_rows,
    select,
    summarize,
    write_records,
    write_rows,
)
from nsrm_harness.paper.tables.run_tables import FIRST_MODELS, StudyError, Tables, TablesResult
from nsrm_harness.paper.tables.study import JUDGED, full_study, quick_study
from nsrm_harness.paper.tables.tables_report import REFUSALS, TABLES, markdown
from nsrm_harness.paper.tables.times import PartTime, ReportTimes
from nsrm_harness.paper.tables.variants import (
    EXACT,
    SAMPLED,
    disturbed_sets,
    training_sets,
    variants,
)
from nsrm_harness.paper.tables.variants import JUDGED as COMPARED

WORKSHOP = Path(__file__).resolve().parent / "domains" / "workshop.toml"
FOUND = (
    DetectorRow("test", 0.0, 500, 2500, 1.0, 1.0, 1.0, 1.0, 0.998, 0.02, 0.6, 16.0),
    DetectorRow("after_3_5", 2.0, 200, 1018, 1.0, 0.999, 0.989, 0.989, 0.977, 0.34, 1.7, 36.0),
)
ROWS = tuple(
    ResultRow(split, model, seed, boxes, 2000, program, 99.0 + seed / 10, 98.0, 96.0, 95.0)
    for split in JUDGED
    for model, boxes, program in (
        ("nsrm", "mask", 97.0),
        ("nsrm", "detector", 96.0),
        ("baseline", "mask", None),
    )
    for seed in range(3)
)
TOOK = (
    PartTime("data", 900.0),
    PartTime("models and baselines", 1500.0),
    PartTime(FIRST_MODELS, 660.0),
)
REFUSED = (
    "seed,kind,set,count,refused,wrongly_accepted\n0,negation,validation,9,1,8\n"
    "0,negation,test,8,7,1\n1,negation,test,8,8,0\n"
)


@pytest.fixture
def report(tmp_path: Path) -> Path:
    folder = tmp_path / "report"
    folder.mkdir()
    write_rows(folder / TABLES, ROWS)
    (folder / REFUSALS).write_text(REFUSED, encoding="utf-8")
    return folder


def test_shares_become_percentages() -> None:
    metrics = Metrics(7, None, 0.5, 0.25, 0.123456, 1.0, 0.001, 0.002, {})
    row = ResultRow.of("test", "baseline", 1, "mask", metrics)
    assert row == ResultRow("test", "baseline", 1, "mask", 7, None, 50.0, 25.0, 12.35, 100.0)


def test_rows_are_read_back(report: Path) -> None:
    assert tuple(read_rows(report / TABLES)) == ROWS
    header = (report / TABLES).read_text(encoding="utf-8").splitlines()[0]
    assert header == "split,model,seed,boxes,episodes,program,o1,o2,iou_2d,iou_3d"


@pytest.mark.parametrize(
    "content", ["", "split,model\n", "a,b,c,d,e,f,g,h,i,j\n1,2,3,4,5,6,7,8,9,10\n"]
)
def test_what_are_no_figures_is_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "tables.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ResultsError, match="expected the columns"):
        read_rows(path)


def test_damaged_figures_are_refused(report: Path) -> None:
    path = report / TABLES
    path.write_text(path.read_text(encoding="utf-8") + "test,nsrm,x\n", encoding="utf-8")
    with pytest.raises(ResultsError, match=r"tables\.csv: cannot read the figures"):
        read_rows(path)


def test_seeds_are_summed_up() -> None:
    chosen = select(ROWS, "test", "nsrm", "mask")
    assert summarize(chosen, "o2") == Summary(98.0, 98.0, 98.0)
    summary = summarize(chosen, "o1")
    assert summary is not None and summary.mean == pytest.approx(99.1)
    assert (summary.least, summary.greatest) == (99.0, 99.2)
    assert summarize(select(ROWS, "test", "baseline", "mask"), "program") is None
    assert summarize([], "o1") is None


def test_the_report_tells_every_split_and_the_papers_figures() -> None:
    text = markdown(
        TablesResult(ROWS, (), FOUND, ("abc", "def"), Path("m"), Path("e"), TOOK, 2), full_study(5)
    )
    assert all(title in text for title in TITLES.values())
    assert "| paper, model | 56.8 | 54.7 | 53.6 | 27.2 | 12.9 |" in text
    assert "| ours, baseline | - | 99.1 (99.0-99.2) |" in text
    assert "| 200, after programs of 3-5 steps | 2 mm | 1018 | 1.0000, 0.9990 |" in text
    assert "at commits abc, def; model seeds 0, 1, 2; data seed 5" in text
    # A part of another part is not counted twice.
    assert f"| {FIRST_MODELS} | 11.0 |\n| total | 40.0 |" in text


def test_the_detectors_table_has_a_dash_where_nothing_was_found(tmp_path: Path) -> None:
    nothing = DetectorRow("test", 0.0, 5, 20, 0.0, None, 0.0, None, None, None, None, 16.0)
    assert "| 20 | 0.0000, - | 0.0000, - | - | - | - | 16 ms |" in table_of([nothing])
    write_records(tmp_path / "detector.csv", COLUMNS, [nothing])
    assert (tmp_path / "detector.csv").read_text().splitlines()[
        1
    ] == "test,0.0,5,20,0.0,,0.0,,,,,16.0"
    # As it is kept, and read again.
    assert DetectorRow(**json.loads(json.dumps(asdict(nothing), allow_nan=False))) == nothing


def a_comparison() -> Comparison:
    """Of a study of three seeds, in which REINFORCE comes near with four of five seeds."""
    study = full_study(5)
    rows, costs = [], []
    for variant in variants(study):
        names = [variant.name, *([variant.name + BEFORE] if variant.before_last else [])]
        for seed in variant.seeds:
            program = 90.0 if variant.name == SAMPLED and seed == 1 else 99.0
            rows += [
                ResultRow(split, name, seed, "mask", 2000, program, 99.0, 99.0, 96.0, 95.0)
                for name in names
                for split in COMPARED
            ]
            slow = 2.0 if variant.name == SAMPLED else 1.0
            costs.append(Cost(variant.name, seed, "joint", 60.0 * slow))
    disturbed = tuple(
        (
            each,
            tuple(
                ResultRow(
                    each.name, name, seed, "mask", 500, 99.0 - each.size, 98.0, 98.0, 96.0, 95.0
                )
                for name, seed in (("nsrm", 0), ("nsrm", 1), ("varied training", 0))
            ),
        )
        for each in disturbed_sets(study)
    )
    return Comparison(tuple(rows), tuple(costs), (("sampled actions", 1),), disturbed)


def test_the_report_tells_what_the_parts_are_worth() -> None:
    outcome = TablesResult(ROWS, (), FOUND, ("abc",), Path("m"), Path("e"), TOOK, 2)
    text = markdown(outcome, full_study(5), a_comparison())
    assert "| no joint training | 99.0 (99.0-99.0) | 95.0 (95.0-95.0) |" in text
    assert "| REINFORCE | 97.2 (90.0-99.0) |" in text and "| 5 | 2.0 |" in text
    assert "4 of 5 seeds are within 1 point" in text
    assert "REINFORCE takes 2.00 times as long." in text
    assert "learned as one by: sampled actions (seed 1)." in text
    assert "| camera, 2 | 97.0 (97.0-97.0) | 95.0 (95.0-95.0) | 97.0 | 95.0 |" in text


def test_the_comparison_is_drawn(tmp_path: Path) -> None:
    path = tmp_path / "comparison.png"
    draw_comparison(a_comparison(), ROWS, full_study(5), path)
    colors = Image.open(path).convert("RGB").getcolors(1 << 24)
    assert colors is not None and len(colors) > 10


def test_variants_differ_in_what_they_say() -> None:
    study = full_study(5)
    every = variants(study)
    assert len({variant.folder for variant in every}) == len(every)
    assert len({(v.config, v.train) for v in every}) == len(every)
    named = {variant.name: variant for variant in every}
    assert named[EXACT].config == study.config and len(named[EXACT].seeds) == 5
    made = training_sets(study)
    assert {v.train for v in every} == {"train", *made}
    sets = disturbed_sets(study)
    assert len({each.name for each in sets}) == len(sets) == 1 + 5 * 3
    assert all(each.settings.seed == 5 for each in sets)


def test_the_readme_gets_the_figures_between_its_marks(report: Path) -> None:
    readme = f"above\n{BEGIN}\nold\n{END}\nbelow\n"
    written = with_figures(readme, report)
    assert written.startswith(f"above\n{BEGIN}\n| |") and written.endswith(f"{END}\nbelow\n")
    assert "old" not in written
    assert "(Table V) | 97.0 (56.8) | 99.1 (54.7) | 98.0 (53.6) |" in written
    assert "Of 16 sentences that must be refused (1 kinds, 3 models), 15 are." in written
    assert with_figures(written, report) == written


def test_a_readme_without_marks_is_refused(report: Path) -> None:
    with pytest.raises(MarkError, match="the page lacks a mark"):
        with_figures("nothing\n", report)


def test_the_readme_gets_what_the_models_understand(tmp_path: Path) -> None:
    rows = [
        (0, language.Counted("test", 40, 39, 1, 0)),
        (0, language.Counted("other", 7, 7, 0, 0)),
        (1, language.Counted("test", 40, 37, 1, 2)),
    ]
    language.write_rows(tmp_path / "language.csv", rows)
    readme = with_language(f"{BEGIN_LANGUAGE}\nold\n{END_LANGUAGE}\n", tmp_path)
    assert "training uses | 80 | 95.0 % | 2.5 % | 2.5 % |" in readme
    assert "Means of 2 models" in readme and "old" not in readme
    (tmp_path / "language.csv").write_text("set,seed\ntest,0\n", encoding="utf-8")
    with pytest.raises(EvaluationError, match="expected the columns set,seed,count"):
        with_language(readme, tmp_path)


def test_nothing_is_published_without_refusals(report: Path, tmp_path: Path) -> None:
    root = tmp_path / "checkout"
    root.mkdir()
    (root / README).write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    (report / REFUSALS).unlink()
    with pytest.raises(PublishError, match=r"refusals\.csv: not found"):
        publish(report, root)
    assert [path.name for path in root.iterdir()] == ["README.md"]


def test_what_is_published_replaces_the_report_before_it_and_no_other(
    report: Path, tmp_path: Path
) -> None:
    root = tmp_path / "checkout"
    (root / "docs/report/arm").mkdir(parents=True)
    (root / README).write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    for old in ("docs/report/gone.png", "docs/report/arm/figures.csv"):
        (root / old).write_text("old", encoding="utf-8")
    publish(report, root)
    published = {path.name for path in (root / "docs/report").iterdir()}
    assert published == {path.name for path in report.iterdir()} | {"arm"}
    assert (root / "docs/report/arm/figures.csv").read_text(encoding="utf-8") == "old"


def test_times_go_on_where_the_making_was_broken_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = 1000.0

    def spend(seconds: float) -> None:
        nonlocal now_s
        now_s += seconds

    monkeypatch.setattr(time, "monotonic", lambda: now_s)
    path = tmp_path / "times.json"
    with pytest.raises(KeyboardInterrupt), ReportTimes(path).of("data"):
        spend(0.5)
        raise KeyboardInterrupt
    assert ReportTimes(path).all() == (PartTime("data", 0.5),)
    times = ReportTimes(path)
    with times.of("data"):
        spend(0.25)
        with times.of("a part") as end:
            spend(1.0)
            end()
            spend(2.0)
    assert times.all() == (PartTime("data", 3.75), PartTime("a part", 1.0))


def test_another_study_in_the_folder_is_refused(tmp_path: Path) -> None:
    domain = domains.load()
    Tables(quick_study(1), domain, tmp_path, LocalProcesses(1))
    Tables(quick_study(1), domain, tmp_path, LocalProcesses(1))
    with pytest.raises(StudyError, match="belongs to another study"):
        Tables(quick_study(2), domain, tmp_path, LocalProcesses(1))
    with pytest.raises(StudyError, match="belongs to another domain"):
        Tables(quick_study(1), domains.load(WORKSHOP), tmp_path, LocalProcesses(1))
