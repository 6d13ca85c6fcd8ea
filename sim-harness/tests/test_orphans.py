"""Worker processes exit when the process that started them is killed."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.paper.tables.processes import ProcessTask, run_all

TESTS = Path(__file__).parent


def two_processes() -> None:
    """Ends when it is killed."""
    for _ in LocalProcesses(2).each(sleep, [(n, ()) for n in range(2)]):
        pass


def two_tasks() -> None:
    """Ends when it is killed."""
    run_all([ProcessTask(str(n), sleep, (), Path(os.devnull)) for n in range(2)], 2, "tasks")


def sleep() -> None:
    """Tell this process's number, and stay."""
    with Path(os.environ["NUMBERS"]).open("a", encoding="utf-8") as numbers:
        print(os.getpid(), file=numbers)
    time.sleep(3600)


@pytest.mark.parametrize("start", ["two_processes", "two_tasks"])
def test_none_outlives_the_one_that_is_killed(start: str, tmp_path: Path) -> None:
    numbers = tmp_path / "numbers"
    numbers.touch()
    paths = os.pathsep.join(map(str, (TESTS.parent, TESTS)))
    first = subprocess.Popen(
        [sys.executable, "-c", f"import {__name__}; {__name__}.{start}()"],
        env={**os.environ, "PYTHONPATH": paths, "NUMBERS": str(numbers)},
        stderr=subprocess.DEVNULL,
    )
    try:
        soon(lambda: len(numbers.read_text(encoding="utf-8").splitlines()) == 2)
    finally:
        first.kill()
        first.wait()
    begun = numbers.read_text(encoding="utf-8").split()
    soon(lambda: not any(Path("/proc", number).exists() for number in begun))


def soon(holds: Callable[[], bool]) -> None:
    """Waits until it holds; the bound only ends a test that hangs."""
    end = time.monotonic() + 600
    while not holds():
        assert time.monotonic() < end, "it did not come to hold"
        time.sleep(0.01)
