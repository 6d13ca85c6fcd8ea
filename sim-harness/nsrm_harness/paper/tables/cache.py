"""Computes figures in separate processes and caches them in files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from nsrm_harness.paper.tables.processes import ProcessTask, run_all
from nsrm_harness.paper.tables.results import write_json


class Maker(Protocol):
    """Computes figures in another process."""

    def figures(self) -> Any:
        """The figures as JSON."""
        ...


def make_all(makers: Mapping[str, Maker], folder: Path, jobs: int, title: str) -> list[Any]:
    """The figures of each maker, from `NAME.json` in `folder` if it exists.

    Raises `TaskError`; earlier results stay cached.
    """
    kept = {name: folder / f"{name}.json" for name in makers}
    tasks = [
        ProcessTask(name, keep, (maker, kept[name]), kept[name].with_suffix(".log"))
        for name, maker in makers.items()
        if not kept[name].exists()
    ]
    run_all(tasks, jobs, title)
    return [json.loads(path.read_text(encoding="utf-8")) for path in kept.values()]


def keep(maker: Maker, path: Path) -> None:
    """Computes the figures and caches them."""
    write_json(path, maker.figures())
