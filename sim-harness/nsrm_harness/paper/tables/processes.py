"""Runs functions in separate processes, one per processor, with their output in log files."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Sequence
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple

from tqdm import tqdm

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.orphans import end_with_parent


class TaskError(HarnessError):
    """A task that failed in its process."""


class ProcessTask(NamedTuple):
    """A module-level function and its arguments."""

    name: str
    function: Callable[..., object]
    arguments: tuple[Any, ...]
    log: Path
    """Its output is appended to this file."""


def run_all(
    tasks: Sequence[ProcessTask],
    jobs: int,
    title: str,
    done: Callable[[ProcessTask], None] = lambda task: None,
) -> None:
    """Runs all tasks, at most `jobs` at a time, each on its own processor; calls `done` with each
    finished one.

    Raises `TaskError` for the first that fails. Then, and on Ctrl-C, the others are terminated.
    """
    # "spawn": a forked child would share the parent's threads and their locks.
    context = multiprocessing.get_context("spawn")
    waiting = list(tasks)
    running: dict[Any, tuple[ProcessTask, BaseProcess, int]] = {}
    free = _processors()[: max(jobs, 1)]
    with tqdm(total=len(tasks), desc=f"{title:>22}") as bar:
        try:
            while waiting or running:
                while waiting and free:
                    task, processor = waiting.pop(0), free.pop(0)
                    process = context.Process(target=_run, args=(task, processor), daemon=True)
                    process.start()
                    running[process.sentinel] = (task, process, processor)
                bar.set_postfix_str(", ".join(task.name for task, _, _ in running.values()))
                for sentinel in wait(list(running)):
                    task, process, processor = running.pop(sentinel)
                    process.join()
                    if process.exitcode != 0:
                        raise TaskError(
                            f"{task.name}: failed: {_last_line(task.log)} (more in {task.log})"
                        )
                    free.append(processor)
                    bar.update()
                    done(task)
        finally:
            for _, process, _ in running.values():
                process.terminate()


def _run(task: ProcessTask, processor: int) -> None:
    end_with_parent()
    task.log.parent.mkdir(parents=True, exist_ok=True)
    with task.log.open("a", encoding="utf-8") as log:
        os.dup2(log.fileno(), sys.stdout.fileno())
        os.dup2(log.fileno(), sys.stderr.fileno())
    if hasattr(os, "sched_setaffinity"):
        # XLA starts as many threads as it sees processors; those of two runs would block each
        # other.
        os.sched_setaffinity(0, {processor})
    try:
        task.function(*task.arguments)
    except HarnessError as error:
        sys.exit(str(error))


def _processors() -> list[int]:
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def _last_line(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    return lines[-1] if lines else "it printed no message"
