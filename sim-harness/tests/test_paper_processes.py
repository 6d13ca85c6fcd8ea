"""Tasks in separate processes: their output, and what a failure does to the others."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from nsrm_harness.paper.tables.processes import ProcessTask, TaskError, run_all


def test_every_task_runs_and_its_words_are_kept(tmp_path: Path) -> None:
    tasks = [ProcessTask(name, print, (name,), tmp_path / name / "log.txt") for name in "abc"]
    ended: list[ProcessTask] = []
    run_all(tasks, 2, "tasks", ended.append)
    assert sorted(ended) == tasks
    assert [task.log.read_text(encoding="utf-8") for task in tasks] == ["a\n", "b\n", "c\n"]


def test_a_failure_is_told_and_ends_the_others(tmp_path: Path) -> None:
    tasks = [
        ProcessTask("slow", stay, (tmp_path / "stayed",), tmp_path / "slow.txt"),
        ProcessTask("bad", sys.exit, ("no data there",), tmp_path / "bad.txt"),
        ProcessTask("late", print, ("late",), tmp_path / "late.txt"),
    ]
    with pytest.raises(TaskError, match=r"bad: failed: no data there \(more in .*bad\.txt\)"):
        run_all(tasks, 2, "tasks")
    for process in multiprocessing.active_children():
        process.join(300)
        assert process.exitcode == -signal.SIGTERM
    assert not (tmp_path / "stayed").exists()
    assert not (tmp_path / "late.txt").exists()


def stay(stayed: Path) -> None:
    """Until it is ended; a file tells where it was not."""
    time.sleep(600)
    stayed.touch()


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C is heard, also where it is not for this process, as in a shell's background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_every_process(tmp_path: Path) -> None:
    tasks = [
        ProcessTask("slow", stay, (tmp_path / "stayed",), tmp_path / "slow.txt"),
        ProcessTask("pressing", press_ctrl_c, (tmp_path / "slow.txt",), tmp_path / "pressing.txt"),
        ProcessTask("late", print, ("late",), tmp_path / "late.txt"),
    ]
    with pytest.raises(KeyboardInterrupt):
        run_all(tasks, 2, "tasks")
    for process in multiprocessing.active_children():
        process.join(300)
        assert process.exitcode == -signal.SIGTERM
    assert not (tmp_path / "stayed").exists()
    assert not (tmp_path / "late.txt").exists()


def press_ctrl_c(after: Path) -> None:
    """In the process that waits for this one, when another's log is there."""
    while not after.exists():
        time.sleep(0.01)
    os.kill(os.getppid(), signal.SIGINT)
    time.sleep(600)
