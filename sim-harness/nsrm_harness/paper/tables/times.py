"""Records how long each part of a report took, summed over all calls."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from nsrm_harness.paper.tables.results import write_json


@dataclass(frozen=True)
class PartTime:
    """A part of the work and its wall time."""

    part: str
    seconds: float


class ReportTimes:
    """The times of all parts, kept in a file."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def all(self) -> tuple[PartTime, ...]:
        """The times, in the order in which the parts were first started."""
        if not self._path.exists():
            return ()
        return tuple(
            PartTime(**took) for took in json.loads(self._path.read_text(encoding="utf-8"))
        )

    @contextmanager
    def of(self, part: str) -> Iterator[Callable[[], None]]:
        """Adds the time until the block ends, however it ends, or until the callable that it yields
        is first called."""
        began, ended = time.monotonic(), False

        def end() -> None:
            nonlocal ended
            if not ended:
                ended = True
                self._add(part, time.monotonic() - began)

        self._add(part, 0.0)
        try:
            yield end
        finally:
            end()

    def _add(self, part: str, seconds: float) -> None:
        seconds_of = {took.part: took.seconds for took in self.all()}
        seconds_of[part] = round(seconds_of.get(part, 0.0) + seconds, 3)
        write_json(self._path, [asdict(PartTime(*item)) for item in seconds_of.items()])
