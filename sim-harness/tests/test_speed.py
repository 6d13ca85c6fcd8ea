"""Speed of trials: whose time is whose, and that measuring changes nothing."""

from __future__ import annotations

import csv
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from PIL import Image

from nsrm_harness.cli.main import main
from nsrm_harness.common.workers import LocalProcesses, Workers
from nsrm_harness.evaluation.manipulation_trials.rows import ROWS
from nsrm_harness.evaluation.manipulation_trials.speed import (
    checks,
    throughput,
)
from nsrm_harness.evaluation.manipulation_trials.speed import (
    speed_report as report,
)
from nsrm_harness.evaluation.manipulation_trials.speed.episode import (
    SpeedEpisode,
    SpeedError,
    mixed,
)
from nsrm_harness.evaluation.manipulation_trials.speed.measure_speed import check_same, rounds
from nsrm_harness.evaluation.manipulation_trials.speed.profile import (
    PARTS,
    SITES,
    Profiled,
    profiled,
)
from nsrm_harness.evaluation.manipulation_trials.speed.stopwatch import REST, Site, Stopwatch
from nsrm_harness.evaluation.manipulation_trials.speed.throughput import measure

SELDOM = {"sampling"}
"""Parts that an episode can do without."""

pytestmark = pytest.mark.slow


class Here:
    """Works in this process, which is warm soon."""

    count = 1

    def each(self, function: Callable[..., Any], tasks: Any) -> Iterator[Any]:
        for key, arguments in tasks:
            yield key, function(*arguments)


@pytest.fixture(scope="module")
def originals() -> list[object]:
    """What is timed, before anything was."""
    return [vars(site.owner)[site.name] for site in SITES]


@pytest.fixture(scope="module")
def episode(originals: list[object]) -> Profiled:
    """With and without the stopwatch."""
    return profiled(*mixed(1, 3), plain_first=False)


def exit_code(*arguments: str | int | Path) -> int:
    with pytest.raises(SystemExit) as caught:
        main(["speed", *(str(argument) for argument in arguments)])
    return caught.value.code if isinstance(caught.value.code, int) else 0


def test_a_moment_belongs_to_what_was_called_last(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = 0.0

    def spend(seconds: float) -> None:
        nonlocal now_s
        now_s += seconds

    def inner() -> None:
        spend(2.0)
        raise ValueError

    def outer(again: bool = True) -> None:
        spend(1.0)
        with pytest.raises(ValueError):
            owner.inner()
        if again:
            owner.outer(again=False)
        spend(4.0)

    owner = SimpleNamespace(inner=inner, outer=outer)
    sites = [Site(owner, "inner", "in"), Site(owner, "outer", "out")]
    monkeypatch.setattr(time, "perf_counter", lambda: now_s)
    watch = Stopwatch()
    with watch.watching(sites):
        spend(8.0)
        owner.outer()
    spend(16.0)
    assert watch.seconds == {"in": 4.0, "out": 10.0, REST: 8.0}
    # The second `outer` was called from the first.
    assert watch.entered == {"in": 2, "out": 1}
    assert watch.whole_s == 22.0
    assert (owner.inner, owner.outer) == (inner, outer)
    with pytest.raises(KeyboardInterrupt), watch.watching(sites):
        raise KeyboardInterrupt
    assert (owner.inner, owner.outer) == (inner, outer)
    with pytest.raises(KeyError, match="gone"), watch.watching([*sites, Site(owner, "gone", "x")]):
        pass
    assert (owner.inner, owner.outer) == (inner, outer)


def test_shares_add_up_and_every_part_is_entered(episode: Profiled) -> None:
    assert min(episode.seconds.values()) >= 0.0
    shares = report.shares([episode])
    assert min(shares.values()) >= 0.0
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-6)
    assert list(shares) == list(PARTS)
    missing = {part for part in PARTS if episode.entered[part] == 0}
    assert missing <= {REST, *SELDOM}
    assert {site.part for site in SITES} | {REST} == set(PARTS)


def test_what_is_timed_ends_as_what_is_not_and_is_left_as_it_was(
    episode: Profiled, originals: list[object]
) -> None:
    assert repr(episode.profiled).encode() == repr(episode.plain).encode()
    assert episode.profiled.end == "succeeded"
    assert [vars(site.owner)[site.name] for site in SITES] == originals
    check_same("here", [episode.profiled], [episode.plain])
    other = replace(episode.plain, corrected_m=(0.1,))
    with pytest.raises(SpeedError, match="there: steps_1 0 ended differently"):
        check_same("there", [other], [episode.plain])


def test_episodes_are_the_first_of_each_row_in_turn() -> None:
    found = [(each.row, each.seed, each.index) for each in mixed(9, 4)]
    assert found == [*((row, 4, 0) for row in ROWS), (ROWS[0], 4, 1), (ROWS[1], 4, 1)]
    assert rounds((2, 2, 1, 3), with_ray=True) == 5


def test_work_begins_when_all_workers_are_warm(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two workers, of which one starts slowly, by a clock that ticks with each task."""
    asked: list[int | None] = []
    working = iter((1, 1, 1, 2, 1, 3))
    process, cold, now_s = 0, {1, 2, 3}, 0.0

    def each(function: Callable[..., Any], tasks: Any) -> Iterator[Any]:
        nonlocal now_s
        for key, arguments in tasks:
            now_s += 1.0
            asked.append(key)
            yield key, function(*arguments)

    def warm_up(_: SpeedEpisode) -> bool:
        nonlocal process
        process = next(working, 1)
        was_cold = process in cold
        cold.discard(process)
        return was_cold

    monkeypatch.setattr(time, "monotonic", lambda: now_s)
    monkeypatch.setattr(time, "sleep", lambda _: None)
    monkeypatch.setattr(os, "getpid", lambda: process)

    ended = SimpleNamespace(tries=(1, 1, 2))
    monkeypatch.setattr(throughput, "warm_up", warm_up)
    monkeypatch.setattr(SpeedEpisode, "carry_out", lambda _: ended)
    workers = cast(Workers, SimpleNamespace(count=2, each=each))
    told: list[int] = []
    measured = measure("two", lambda: nullcontext(workers), mixed(2, 0), lambda: told.append(1))
    assert asked == [None, None, None, None, 0, 1]
    assert (measured.start_s, measured.work_s, measured.late) == (4.0, 2.0, 1)
    assert (measured.episodes_a_minute, measured.sub_goals_a_minute) == (60.0, 180.0)
    assert len(told) == 2

    # From here on only the first one works.
    monkeypatch.setattr(throughput, "MAX_START_S", 10.0)
    with pytest.raises(
        SpeedError, match="1 of 2 workers have started after 10 s: use fewer --jobs"
    ):
        measure("two", lambda: nullcontext(workers), mixed(2, 0), lambda: None)


def test_the_command_writes_all_that_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(LocalProcesses, "each", Here.each)
    monkeypatch.setattr(checks, "SCENES", 1)
    monkeypatch.setattr(checks, "CONFIGURATIONS", 4)
    out = tmp_path / "made" / "here"
    monkeypatch.setitem(sys.modules, "ray", None)
    options = ("--episodes", 1, "--seed", 3, "--jobs", 1, "--quiet")
    assert exit_code(*options, "--out", out) == 0
    printed = capsys.readouterr().out
    rows: dict[str, list[dict[str, str]]] = {}
    for name in ("speed", "profile", "checks"):
        with (out / f"{name}.csv").open(encoding="utf-8") as file:
            rows[name] = list(csv.DictReader(file))
    assert tuple(rows["speed"][0]) == report.SPEED_FIELDS
    (one,) = rows["speed"]
    assert (one["workers"], one["count"], one["episodes"]) == ("1 process", "1", "1")
    assert (one["sub_goals"], one["late"]) == ("1", "0")
    assert tuple(rows["profile"][0]) == report.PROFILE_FIELDS
    assert [row["part"] for row in rows["profile"]] == list(PARTS)
    assert sum(float(row["share"]) for row in rows["profile"]) == pytest.approx(1.0, abs=1e-6)
    assert tuple(rows["checks"][0]) == report.CHECKS_FIELDS
    assert [(row["holds"], row["asked"]) for row in rows["checks"]] == 2 * [
        ("0", "touches"),
        ("0", "free"),
        ("1", "touches"),
        ("1", "free"),
    ]
    assert {row["configurations"] for row in rows["checks"]} == {"4"}
    assert "| 1 process |" in printed and "| inverse kinematics |" in printed
    assert "a block in the hand | " in printed
    assert "Ray is not installed and was not measured" in printed
    assert (out / "speed.md").read_text(encoding="utf-8") in printed
    with Image.open(out / "speed.png") as picture:
        assert picture.width > 1000


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--episodes", 0), "0 is not in the range x>=1"),
        (("--jobs", 0), "0 is not in the range x>=1"),
        (("--jobs", "many"), "'many' is not a valid integer"),
        (("--seed", -1), "-1 is not in the range x>=0"),
        (("--row", "steps_1"), "No such option"),
    ],
)
def test_bad_options_are_refused(
    options: tuple[str | int, ...], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code(*options) == 2
    assert why in capsys.readouterr().err


def test_a_folder_that_can_not_be_made_and_a_missing_ray_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert exit_code("--no-ray", "--out", tmp_path / "file" / "out") == 2
    assert "another --out" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "ray", None)
    assert exit_code("--ray", "--quiet", "--out", tmp_path) == 2
    assert "Ray is not installed: pip install" in capsys.readouterr().err
