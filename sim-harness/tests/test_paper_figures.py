"""The paper's figures: their sentences, scenes and results."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import nsrm
import pytest
from harness_command import run as run_harness
from PIL import Image

from nsrm_harness import domain as domains
from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.domain.program import Step, canonical
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementVerdict
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.paper.figures import figures_report as report
from nsrm_harness.paper.figures.run_figures import CompletedStep, VariationResult, run
from nsrm_harness.paper.figures.scenes import FIGURES, Figure, draw

DOMAIN = domains.load()
ON_BLUE, ON_CYAN = Step("MoveOn", ("cyan",), ("blue",)), Step("MoveOn", ("blue",), ("cyan",))

pytestmark = pytest.mark.slow


def exit_code(*arguments: str | int | Path) -> int:
    return run_harness("figures", *arguments)


def test_the_sentences_mean_what_the_judge_goes_by() -> None:
    model = nsrm.Model.pretrained()
    for figure in FIGURES:
        understood = [
            Step(step.action, tuple(step.object), tuple(step.reference))
            for step in model.parse(figure.sentence).steps
        ]
        assert canonical(understood) == canonical(figure.program), figure.sentence


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: str(figure.number))
def test_a_scene_has_what_is_named_once_and_room_for_it(figure: Figure) -> None:
    scenes = [draw(figure, DOMAIN, 0, variation) for variation in range(20)]
    assert scenes[3] == draw(figure, DOMAIN, 0, 3)
    assert scenes[3] != draw(figure, DOMAIN, 1, 3)
    assert len({scene.arrangement.poses for scene in scenes}) == len(scenes)
    assert {len(scene.arrangement.blocks) for scene in scenes} == {4, 5, 6}
    for scene in scenes:
        arrangement = scene.arrangement
        values = [set(block.values.values()) for block in arrangement.blocks]
        for step, move in zip(figure.program, scene.moves, strict=True):
            assert move.action.name == step.action
            for said, index in ((step.object, move.moved), (step.reference, move.reference)):
                assert [i for i, has in enumerate(values) if set(said) <= has] == [index]
            assert arrangement.allowed(move)
            arrangement = arrangement.after(move)


def test_figures_do_not_share_their_chance() -> None:
    four, same_words = FIGURES[2], replace(FIGURES[2], number=5)
    assert draw(four, DOMAIN, 0, 0) != draw(same_words, DOMAIN, 0, 0)


def test_three_steps_are_carried_out_and_drawn(tmp_path: Path) -> None:
    path = tmp_path / "figure.png"
    ended = run(FIGURES[3], 0, 0, path)
    assert ended.end == "succeeded", ended.why
    assert len(ended.steps) == 3
    assert all(step.verdict.is_as_said and step.goal_off_m < 0.005 for step in ended.steps)
    with Image.open(path) as picture:
        wide, high = picture.size
    # Five panels: three and two.
    assert wide == 1800 and high > 800
    assert run(FIGURES[3], 0, 0) == ended


@pytest.mark.parametrize(
    ("sentence", "program", "end", "why"),
    [
        (
            "put cyan block on the blue block",
            (ON_CYAN,),
            "failed",
            "attempt 1 at a step did not succeed",
        ),
        ("put red block on blue block", FIGURES[2].program, "failed", "1 steps instead of 2"),
        ("put purple block on the blue block", (ON_BLUE,), "refused", "model: "),
    ],
)
def test_what_is_not_as_said_is_told_with_its_reason(
    tmp_path: Path, sentence: str, program: tuple[Step, ...], end: str, why: str
) -> None:
    path = tmp_path / "figure.png"
    ended = run(replace(FIGURES[0], sentence=sentence, program=program), 0, 0, path)
    assert ended.end == end and why in ended.why, ended
    assert path.exists()


def test_the_files_count_how_variations_ended(tmp_path: Path) -> None:
    first = VariationResult(3, 0, 7, FIGURES[1].sentence, "succeeded", "", ())
    ended = [first, replace(first, variation=1, end="refused", why="no room"), replace(first)]
    report.write_csv(ended, tmp_path / "figures.csv")
    assert (tmp_path / "figures.csv").read_text(encoding="utf-8").split() == [
        "figure,variations,succeeded,refused,failed",
        "3,3,2,1,0",
    ]
    assert "| 3 | 2 | 1 | 0 |" in report.text(ended)
    assert "figure 3, variation 1: refused: no room" in report.text(ended)


def test_the_command_writes_all_that_it_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "made" / "here"
    assert exit_code("--jobs", 1, "--quiet", "--seed", 2, "--out", out) == 0
    printed = capsys.readouterr().out
    with (out / "figures.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["figure"] for row in rows] == ["2", "3", "4", "5"]
    lines = [json.loads(line) for line in (out / "figures.jsonl").read_text().splitlines()]
    for figure, row, line in zip(FIGURES, rows, lines, strict=True):
        assert row["variations"] == row["succeeded"] == "1" and line["end"] == "succeeded"
        assert line["sentence"] == figure.sentence and line["seed"] == 2
        assert figure.sentence in printed
        assert (out / f"figure_{figure.number}.png").exists()


def test_a_figure_that_does_worse_than_chance_ends_with_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def each(
        _: LocalProcesses, function: object, tasks: Iterable[Any]
    ) -> Iterator[tuple[Any, VariationResult]]:
        for key, (figure, seed, variation, *_rest) in tasks:
            end = "failed" if figure.number == 3 and variation < 3 else "succeeded"
            yield (
                key,
                VariationResult(
                    figure.number, variation, seed, figure.sentence, end, "it fell", ()
                ),
            )

    monkeypatch.setattr(LocalProcesses, "each", each)
    arguments = ("--jobs", 1, "--quiet", "--out", tmp_path, "--variations", 4)
    assert exit_code(*arguments) == 1
    told = capsys.readouterr().err
    assert "figure 3: 1 of 4 succeeded, the goal is 98.0 %" in told and "figure 2" not in told
    assert (tmp_path / "figures.csv").exists()


def test_what_was_touched_is_told() -> None:
    good = PlacementVerdict(0.001, 0.0, 0.0, True, (), 5.0)
    done = CompletedStep(good, 0.0, 0.0, 1)
    first = VariationResult(3, 0, 7, FIGURES[1].sentence, "succeeded", "", (done,))
    touching = replace(done, verdict=replace(good, touched=("block 1 and panda_hand",)))
    ended = [first, replace(first, figure=4, steps=(done, touching))]
    assert report.missed([first]) == []
    assert report.missed(ended) == ["figure 4: unexpected contact: block 1 and panda_hand"]
    assert "unexpected contact of the arm or its block: 1." in report.text(ended)
    # One that fails may be chance.
    assert report.missed([replace(first, end="failed")]) == []


def test_more_steps_that_are_understood_later_are_judged_by_the_last_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    follow = ClosedLoop.follow

    def one_more(self: ClosedLoop, sentence: str) -> None:
        follow(self, sentence)
        self.begin(1)
        self.reached(1, self.performed[-1])

    monkeypatch.setattr(ClosedLoop, "follow", one_more)
    ended = run(FIGURES[0], 2, 0)
    assert ended.end == "succeeded", ended.why
    assert [step.verdict.step for step in ended.steps] == [0, 0]


def test_bad_input_ends_with_2_and_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    assert exit_code("--variations", 0) == 2
    assert exit_code("--out", tmp_path / "file") == 2
    capsys.readouterr()
    assert exit_code("--out", tmp_path / "file" / "below") == 2
    assert "another --out" in capsys.readouterr().err
