"""The arm knows the world only through images: its code has no access to the ground truth."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import pytest
from another_process import TESTS, elsewhere

from nsrm_harness.evaluation.manipulation_trials import disturbed_episode, trial
from nsrm_harness.evaluation.manipulation_trials.rows import ROWS
from nsrm_harness.nodes import arm_mover
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.simulation.arm_world import ArmWorld

TRUTH = (
    "pybullet",
    "nsrm_harness.simulation.bullet",
    "nsrm_harness.simulation.world",
    "nsrm_harness.simulation.arm_world",
    "nsrm_harness.simulation.moving_arm",
    "nsrm_harness.data.ground_truth",
    "nsrm_harness.data",
)
"""A module of one of these names, or in one of these packages."""

IMPORTING = """
import importlib, pkgutil, sys
from nsrm_harness import manipulation
for module in pkgutil.walk_packages(manipulation.__path__, "nsrm_harness.manipulation."):
    importlib.import_module(module.name)
print(*sorted(sys.modules), sep="\\n")
"""


FOLLOWING = """
import sys
import nsrm_harness.nodes.closed_loop
print(*sorted(sys.modules), sep="\\n")
"""

pytestmark = pytest.mark.slow


def loaded_with(code: str) -> set[str]:
    return set(elsewhere(code).split())


def truths(modules: set[str]) -> set[str]:
    return {
        module
        for module in modules
        if any(module == name or module.startswith(f"{name}.") for name in TRUTH)
    }


def test_no_module_of_the_arm_loads_what_knows_the_truth() -> None:
    modules = loaded_with(IMPORTING)
    written = {path.stem for path in (TESTS.parent / "nsrm_harness" / "manipulation").glob("*.py")}
    assert {f"nsrm_harness.manipulation.{name}" for name in written - {"__init__"}} <= modules
    assert truths(modules) == set()


def test_what_follows_a_sentence_loads_nothing_that_knows_the_truth() -> None:
    modules = loaded_with(FOLLOWING)
    used = {"nodes.closed_loop", "manipulation.retries", "perception.observer"}
    assert {f"nsrm_harness.{name}" for name in used} <= modules
    assert truths(modules) == set()


class Watch:
    """Who asks for the truth, or sets it, while a sentence is followed: the names of modules."""

    ASKED = ("poses", "pose", "placed", "nearest", "contacts", "place", "slow")
    WORLDS = ("nsrm_harness.simulation.world", "nsrm_harness.simulation.arm_world")

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.readers: set[str] = set()
        self._is_on = False
        for name in self.ASKED:
            monkeypatch.setattr(ArmWorld, name, self._watched(getattr(ArmWorld, name)))
        monkeypatch.setattr(ClosedLoop, "follow", self._watching(ClosedLoop.follow))

    def _watched(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def asked(*arguments: Any) -> Any:
            if self._is_on:
                self.readers.add(self._reader())
            return function(*arguments)

        return asked

    def _watching(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def follow(*arguments: Any) -> None:
            self._is_on = True
            try:
                function(*arguments)
            finally:
                self._is_on = False

        return follow

    def _reader(self) -> str:
        """The first module up the stack that is not the world's own."""
        frame = sys._getframe()
        while frame.f_globals["__name__"] in (__name__, *self.WORLDS):
            assert frame.f_back is not None
            frame = frame.f_back
        return str(frame.f_globals["__name__"])


WATCHING = ("judge", "fault_injection", "disturbed_episode")
"""Of `nsrm_harness.evaluation.manipulation_trials`."""


def others(readers: set[str]) -> set[str]:
    """Those that are to know no truth; what draws the pictures does."""
    known = {f"nsrm_harness.evaluation.manipulation_trials.{name}" for name in WATCHING}
    return {
        reader
        for reader in readers
        if reader not in known and not reader.startswith("nsrm_harness.simulation.render.")
    }


def test_nobody_but_judge_and_disturber_asks_for_the_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    (row,) = (row for row in ROWS if row.name == "steps_2")
    watch = Watch(monkeypatch)
    assert trial.run(row, 5, 0).steps
    # It was watched.
    assert "nsrm_harness.evaluation.manipulation_trials.judge" in watch.readers
    assert any(reader.startswith("nsrm_harness.simulation.render.") for reader in watch.readers)
    assert others(watch.readers) == set()
    for loop in ("closed", "open"):
        assert disturbed_episode.run_disturbed("goal_taken", loop, 771, 0).steps
    assert "nsrm_harness.evaluation.manipulation_trials.fault_injection" in watch.readers
    assert others(watch.readers) == set()


@pytest.mark.parametrize("question", ["poses()", "placed()", "nearest((0.4, 0.0, 0.0))"])
def test_an_arm_that_asks_for_the_truth_is_noticed(
    monkeypatch: pytest.MonkeyPatch, question: str
) -> None:
    (row,) = (row for row in ROWS if row.name == "steps_1")
    watch = Watch(monkeypatch)
    peeking: dict[str, Any] = {"__name__": "nsrm_harness.manipulation.peeking"}
    exec(f"def peek(world):\n    return world.{question}", peeking)
    reach = arm_mover.reach_sub_goal

    def peeks(body: ArmWorld, *arguments: Any, **named: Any) -> Any:
        peeking["peek"](body)
        return reach(body, *arguments, **named)

    monkeypatch.setattr(arm_mover, "reach_sub_goal", peeks)
    trial.run(row, 5, 0)
    assert others(watch.readers) == {"nsrm_harness.manipulation.peeking"}


def test_the_truth_would_be_noticed() -> None:
    names = ("simulation.arm_world", "data.ground_truth", "data.file")
    code = "import sys, " + ", ".join(f"nsrm_harness.{name}" for name in names)
    found = truths(loaded_with(f"{code}\nprint(*sys.modules, sep='\\n')"))
    assert set(TRUTH) <= found
