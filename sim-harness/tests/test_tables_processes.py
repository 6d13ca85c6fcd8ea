"""Tasks in processes of their own: what they print, and what a failure does to the others."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest

from nsrm_harness.tables.processes import Task, TaskError, run_all


def test_every_task_runs_and_its_words_are_kept(tmp_path: Path) -> None:
    tasks = [Task(name, print, (name,), tmp_path / name / "log.txt") for name in "abc"]
    run_all(tasks, 2, "tasks")
    assert [task.log.read_text(encoding="utf-8") for task in tasks] == ["a\n", "b\n", "c\n"]


def test_a_failure_is_told_and_ends_the_others(tmp_path: Path) -> None:
    tasks = [
        Task("slow", time.sleep, (600,), tmp_path / "slow.txt"),
        Task("bad", sys.exit, ("no data there",), tmp_path / "bad.txt"),
        Task("late", print, ("late",), tmp_path / "late.txt"),
    ]
    began = time.monotonic()
    with pytest.raises(TaskError, match=r"bad: failed: no data there \(more in .*bad\.txt\)"):
        run_all(tasks, 2, "tasks")
    # Far less than the slow one takes, however loaded the machine.
    assert time.monotonic() - began < 300
    assert not (tmp_path / "late.txt").exists()
