"""Trials of the arm: which episodes are drawn, and what is reported about them."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from another_process import elsewhere

from nsrm_harness import domain as domains
from nsrm_harness.cli.main import main
from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.manipulation_trials import (
    provenance,
    trial,
)
from nsrm_harness.evaluation.manipulation_trials import (
    trials_report as report,
)
from nsrm_harness.evaluation.manipulation_trials.disturbed_episode import DISTURBED_ROWS
from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementVerdict
from nsrm_harness.evaluation.manipulation_trials.rows import ROWS, TrialRow, draw
from nsrm_harness.evaluation.manipulation_trials.run_trials import TrialsError, episode, films, run

BY_NAME = {row.name: row for row in ROWS}
GOOD = PlacementVerdict(0.001, 0.0, 0.0, True, (), 5.0)

pytestmark = pytest.mark.slow


def ended(
    row: str, index: int, end: str, *steps: PlacementVerdict, kind: str = ""
) -> EpisodeResult:
    """How an episode ended."""
    why = "" if end == "succeeded" else "so it was"
    return EpisodeResult(row, index, "put it there", end, why, kind, steps, (0.002,), (1,))


@pytest.fixture(scope="module")
def domain() -> Domain:
    return domains.load()


def test_a_stack_is_built_block_on_block_and_a_seed_draws_one_episode(domain: Domain) -> None:
    for index in range(5):
        drawn = draw(BY_NAME["stack_4"], generator(3, "arm_stack_4", index), domain)
        moves = drawn.task.moves
        assert [move.reference for move in moves[1:]] == [move.moved for move in moves[:-1]]
        assert len({moves[0].reference, *(move.moved for move in moves)}) == 4
        assert draw(BY_NAME["stack_4"], generator(3, "arm_stack_4", index), domain) == drawn
    assert len(draw(BY_NAME["steps_5"], generator(3, "arm_steps_5", 0), domain).task.moves) == 5


def test_the_same_seed_is_the_same_episode_in_another_process() -> None:
    here = trial.run(BY_NAME["steps_1"], 5, 1)
    there = elsewhere(
        "import json; from dataclasses import asdict;"
        "from nsrm_harness.evaluation.manipulation_trials import rows, trial;"
        "print(json.dumps(asdict(trial.run(rows.ROWS[0], 5, 1))))"
    )
    assert json.loads(there) == json.loads(json.dumps(asdict(here)))
    assert here.end == "succeeded" and here.steps[0].is_as_said
    assert 2.0 < here.steps[0].seconds < 10.0


def test_the_control_is_given_the_truth_and_the_others_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def blind(*_: object) -> None:
        raise AssertionError("the truth was looked at")

    monkeypatch.setattr(trial._ByTruth, "_true_objects", blind)
    assert trial.run(BY_NAME["steps_1"], 5, 0).end != "failed"
    with pytest.raises(AssertionError, match="the truth"):
        trial.run(BY_NAME["control"], 5, 0)


@pytest.mark.parametrize("row", [BY_NAME["steps_1"], DISTURBED_ROWS[0]], ids=lambda row: row.name)
def test_a_worker_without_the_domain_s_file_carries_an_episode_out(
    domain: Domain, monkeypatch: pytest.MonkeyPatch, row: TrialRow
) -> None:
    monkeypatch.setattr(domains, "load", lambda: pytest.fail("there is no such file"))
    assert episode(row, 5, 0, None, domain).row == row.name


def test_what_was_broken_off_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, rows = tmp_path / "out" / "trials.jsonl", [BY_NAME["steps_1"]]
    first = run(rows, 1, 5, LocalProcesses(1), path, quiet=True)
    kept = path.read_text()
    path.write_text(kept + '{"row": "steps_1", "ind')
    monkeypatch.setattr(LocalProcesses, "each", lambda *_: pytest.fail("it was done again"))
    with pytest.raises(pytest.fail.Exception):
        run(rows, 2, 5, LocalProcesses(1), path, quiet=True)
    assert path.read_text() == kept
    monkeypatch.setattr(LocalProcesses, "each", lambda self, function, tasks: iter(list(tasks)[:0]))
    assert run(rows, 1, 5, LocalProcesses(1), path, quiet=True) == first
    with pytest.raises(TrialsError, match="seed 5"):
        run(rows, 1, 6, LocalProcesses(1), path, quiet=True)
    with monkeypatch.context() as changed:
        changed.setattr(provenance, "digest", lambda: "another")
        with pytest.raises(TrialsError, match=r"trials.jsonl: .* the code or the model: .* remove"):
            run(rows, 1, 5, LocalProcesses(1), path, quiet=True)
    # As they were before it was written down.
    path.write_text(f'{{"seed": 5}}\n{kept.partition(chr(10))[2]}')
    with pytest.raises(TrialsError, match="the code or the model"):
        run(rows, 1, 5, LocalProcesses(1), path, quiet=True)
    path.write_text("something else\n")
    with pytest.raises(TrialsError, match="not a file of trials"):
        run(rows, 1, 5, LocalProcesses(1), path, quiet=True)


def test_a_changed_source_is_another_state_of_the_code(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    source = tmp_path / "below" / "arm.py"
    source.write_text("a = 1\n")
    (tmp_path / "notes.txt").write_text("b")
    first = provenance._of((tmp_path, "*.py"))
    (tmp_path / "notes.txt").write_text("c")
    assert provenance._of((tmp_path, "*.py")) == first
    source.write_text("a = 2\n")
    second = provenance._of((tmp_path, "*.py"))
    source.rename(tmp_path / "arm.py")
    assert len({first, second, provenance._of((tmp_path, "*.py"))}) == 3
    assert provenance.digest() == provenance.digest() and len(provenance.digest()) == 64


def test_films_of_an_earlier_run_are_removed_and_nothing_else(tmp_path: Path) -> None:
    old, someones = tmp_path / "failed-steps_1-7", tmp_path / "my-films"
    with_notes = tmp_path / "refused-stack_3-12"
    for folder in (old, someones, with_notes):
        folder.mkdir()
        for name in ("film.gif", "strip.png"):
            (folder / name).touch()
    (with_notes / "notes.txt").touch()
    films([], [], 5, LocalProcesses(1), tmp_path)
    assert not old.exists()
    assert {path.name for path in someones.iterdir()} == {"film.gif", "strip.png"}
    assert [path.name for path in with_notes.iterdir()] == ["notes.txt"]
    films([], [], 5, LocalProcesses(1), tmp_path / "none")


def test_rows_are_counted_and_told(tmp_path: Path) -> None:
    rows = [BY_NAME["steps_1"], BY_NAME["control"]]
    touched = replace(GOOD, off_m=0.009, touched=("block 2 and panda_hand",))
    control = ended("control", 0, "succeeded", replace(GOOD, off_m=0.002))
    all_ended = [
        ended("steps_1", 0, "succeeded", GOOD),
        ended("steps_1", 1, "failed", touched),
        ended("steps_1", 2, "refused", kind="no path"),
        replace(control, corrected_m=(0.0,)),
    ]
    lines = report.counted(rows, all_ended)
    report.write_csv(lines, tmp_path / "trials.csv")
    header, first, second = (tmp_path / "trials.csv").read_text().splitlines()
    assert header == (
        "row,episodes,succeeded,refused,failed,position_p50_mm,position_p95_mm,seconds_p50"
    )
    assert first == "steps_1,3,1,1,1,5.00,8.60,5.00"
    assert second == "control,1,1,0,0,2.00,2.00,5.00"
    text = report.text(lines)
    assert "| one step | 3 | 33.3 % | 99.0 % | 1 | 1 | 5.00 mm | 8.60 mm | 5.00 |" in text
    # The control's are not the model's.
    assert "Of 3 sub-goals of the model, refused: no path 1 (33.3 %)" in text
    assert "unexpected contact of the arm or its block: 1." in text
    assert "100.0 % by more than 1.0 mm, 2.0 mm in the median" in text
    assert "- steps_1 2: refused: so it was" in text and "steps_1 0" not in text
    assert "given up" not in text
    assert [each.index for each in report.worst(lines, 3)] == [1, 2, 0]
    assert report.worst(lines, 3)[2].row == "control"
    report.draw(lines, tmp_path / "trials.png")
    assert (tmp_path / "trials.png").stat().st_size > 10_000


def test_a_row_without_a_step_has_no_figures_of_steps(tmp_path: Path) -> None:
    row = BY_NAME["steps_1"]
    refused = [
        replace(ended("steps_1", index, "refused", kind="no path"), corrected_m=())
        for index in range(100)
    ]
    lines = report.counted([row], refused)
    report.write_csv(lines, tmp_path / "trials.csv")
    assert (tmp_path / "trials.csv").read_text().splitlines()[1] == "steps_1,100,0,100,0,,,"
    text = report.text(lines)
    assert "| one step | 100 | 0.0 % | 99.0 % | 100 | 0 | – | – | – |" in text
    assert "nan" not in text and "corrected" not in text
    assert [what for what in report.missed(lines) if "off" in what or "seconds" in what] == []


def test_the_best_have_the_most_steps_and_are_the_least_off() -> None:
    off = replace(GOOD, off_m=0.002)
    all_ended = [
        ended("steps_1", 0, "succeeded", off),
        ended("steps_1", 1, "succeeded", GOOD),
        ended("steps_2", 2, "succeeded", GOOD, off),
        ended("steps_2", 3, "failed", GOOD, GOOD),
    ]
    lines = report.counted([BY_NAME["steps_1"], BY_NAME["steps_2"]], all_ended)
    assert [each.index for each in report.best(lines, 9)] == [2, 1, 0]
    assert [each.index for each in report.best(lines, 1)] == [2]


def test_what_can_be_chance_is_told_from_what_can_not() -> None:
    row = BY_NAME["steps_1"]

    def told(*ends: str, step: PlacementVerdict = GOOD) -> list[str]:
        all_ended = [ended("steps_1", index, end, step) for index, end in enumerate(ends)]
        return report.missed(report.counted([row], all_ended))

    assert told(*8 * ["succeeded"], *2 * ["failed"]) == []
    (missed,) = told(*7 * ["succeeded"], *3 * ["refused"])
    assert missed == "one step: 7 of 10 succeeded, the goal is 99.0 %"
    (touched,) = told("succeeded", step=replace(GOOD, touched=("block 1 and panda_hand",)))
    assert touched == "one step: unexpected contact: block 1 and panda_hand"


@pytest.mark.parametrize(
    ("name", "step", "missed"),
    [
        ("steps_1", replace(GOOD, off_m=0.0019), ""),
        ("steps_1", replace(GOOD, off_m=0.0021), "median error 2.10 mm, the goal is 2.0"),
        ("steps_1", replace(GOOD, seconds=6.1), "median 6.10 s per step, the goal is 6.0"),
        ("control", replace(GOOD, off_m=0.0004), ""),
        ("control", replace(GOOD, off_m=0.0006), "95 % error 0.60 mm, the goal is 0.5"),
    ],
)
def test_a_row_of_enough_episodes_reaches_the_other_goals_too(
    name: str, step: PlacementVerdict, missed: str
) -> None:
    def told(count: int) -> list[str]:
        all_ended = [ended(name, index, "succeeded", step) for index in range(count)]
        return report.missed(report.counted([BY_NAME[name]], all_ended))

    assert told(report.ENOUGH - 1) == []
    found = told(report.ENOUGH)
    assert len(found) == bool(missed)
    assert all(f"{BY_NAME[name].title}: {missed}" in each for each in found)


def test_a_row_of_enough_episodes_is_not_far_off_nor_refused_too_often() -> None:
    row, far = BY_NAME["steps_5"], replace(GOOD, off_m=0.006)

    def told(*all_ended: EpisodeResult) -> list[str]:
        return report.missed(report.counted([row], all_ended))

    good = [ended("steps_5", index, "succeeded", GOOD) for index in range(94)]
    (off,) = told(*good, *[ended("steps_5", index, "failed", far) for index in range(94, 100)])
    assert off == "five steps: 95 % error 6.00 mm, the goal is 5.0"
    refused = [ended("steps_5", index, "refused", kind="no room") for index in range(94, 100)]
    (often,) = told(*good, *refused)
    assert often == "five steps: 6 of 100 sub-goals refused, the goal is 1 %"


def test_a_missed_goal_ends_with_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    failed = [ended("steps_1", index, "failed", GOOD) for index in range(10)]
    monkeypatch.setattr(
        "nsrm_harness.evaluation.manipulation_trials.run_trials.run", lambda *_, **__: failed
    )
    with pytest.raises(SystemExit) as stopped:
        main(["trials", "--quick", "--row", "steps_1", "--out", str(tmp_path)])
    assert stopped.value.code == 1
    assert "0 of 10 succeeded" in capsys.readouterr().err
    assert (tmp_path / "trials.csv").exists()


def test_who_interferes_may_be_touched_and_an_open_loop_has_no_goal(tmp_path: Path) -> None:
    rows = [row for row in DISTURBED_ROWS if row.kind == "goal_taken"]
    touched = replace(GOOD, touched=("block 1 and panda_hand",))
    all_ended = [ended(row.name, 0, "failed", touched) for row in rows]
    lines = report.counted(rows, all_ended)
    assert report.missed(lines) == []
    text = report.text(lines)
    assert "another block put onto the goal: loop open | 1 | 0.0 % | 0.0 % | – |" in text
    # It has no goal, and is not shown as one that ended badly.
    assert [each.row for each in report.worst(lines, 9)] == ["goal_taken_closed"]
    assert report.best(lines, 9) == []
    # Who interferes is not judged by it.
    assert "contact" not in text
    report.draw(lines[1:], tmp_path / "open.png")
    assert (tmp_path / "open.png").stat().st_size > 10_000


def test_open_loops_are_not_among_the_refused() -> None:
    rows = [row for row in DISTURBED_ROWS if row.kind == "goal_taken"]
    all_ended = [ended(row.name, 0, "refused", kind="no room") for row in rows]
    lines = report.counted(rows, all_ended)
    assert "Of 1 sub-goals of the model, refused: no room 1 (100.0 %)" in report.text(lines)
    assert "refused: " not in report.text(lines[1:])


def test_a_step_that_is_done_again_is_off_by_its_last_attempt() -> None:
    (row,) = (row for row in DISTURBED_ROWS if row.name == "grasp_fails_closed")
    far, second = replace(GOOD, off_m=0.2), replace(GOOD, off_m=0.002, step=1)
    done = ended(row.name, 0, "succeeded", far, replace(far, step=1), GOOD, second)
    given_up = ended(row.name, 1, "succeeded", GOOD, replace(far, step=1))
    lines = report.counted([row], [done, replace(given_up, why="it was tried 3 times")])
    assert [line.off_mm.tolist() for line in lines] == [[1.0, 2.0, 1.0]]
    assert "at its last attempt" in report.text(lines)
    failed = report.counted([row], [replace(given_up, end="failed", why="it fell")])
    assert failed[0].off_mm.tolist() == [1.0, 200.0]


def test_what_had_to_be_given_up_is_not_counted_as_done(tmp_path: Path) -> None:
    rows = [row for row in DISTURBED_ROWS if row.name == "grasp_fails_closed"]
    all_ended = [
        ended(rows[0].name, 0, "succeeded", GOOD),
        replace(ended(rows[0].name, 1, "succeeded", GOOD), why="1 was tried 3 times; giving up"),
        replace(ended(rows[0].name, 2, "succeeded", GOOD), why="1 was tried 3 times; giving up"),
        ended(rows[0].name, 3, "failed", GOOD),
    ]
    text = report.text(report.counted(rows, all_ended))
    assert "| succeeded | correctly given up | goal |" in text
    assert "loop closed | 4 | 25.0 % | 50.0 % | 95.0 % | 0 | 1 |" in text
    report.write_csv(report.counted(rows, all_ended), tmp_path / "trials.csv")
    header, line = (tmp_path / "trials.csv").read_text().splitlines()
    assert header.endswith("position_p95_mm,seconds_p50,given_up")
    assert line.startswith("grasp_fails_closed,4,3,0,1,") and line.endswith(",5.00,2")


def test_a_row_that_is_none_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["trials", "--row", "steps_9", "--out", str(tmp_path)])
    assert stopped.value.code == 2
    assert "'steps_9': expected one of steps_1, steps_2" in capsys.readouterr().err
