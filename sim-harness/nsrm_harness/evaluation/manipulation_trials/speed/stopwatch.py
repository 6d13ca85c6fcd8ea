"""Measures where the time of one thread goes by wrapping functions; each moment belongs to the
innermost wrapped function."""

from __future__ import annotations

import functools
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

REST = "rest"


class Site(NamedTuple):
    """Where a function is looked up when it is called: a class or module, and its name there."""

    owner: Any
    name: str
    part: str


class Stopwatch:
    """Exclusive times of parts.

    * `seconds`: time of each part, without the parts called from it
    * `entered`: how often each was called from another part
    * `whole_s`: total time watched, from two readings of the clock
    """

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.entered: Counter[str] = Counter()
        self.whole_s = 0.0
        self._parts = [REST]
        self._since_s = 0.0

    @contextmanager
    def watching(self, sites: Sequence[Site]) -> Iterator[None]:
        """Wraps these functions while the block runs; time outside of them is `REST`."""
        originals = [(site, vars(site.owner)[site.name]) for site in sites]
        began_s = time.perf_counter()
        self._parts, self._since_s = [REST], began_s
        try:
            for site, original in originals:
                setattr(site.owner, site.name, self._timed(original, site.part))
            yield
        finally:
            for site, original in originals:
                setattr(site.owner, site.name, original)
            self._lap()
            self.whole_s += self._since_s - began_s

    def _lap(self) -> None:
        now_s = time.perf_counter()
        self.seconds[self._parts[-1]] += now_s - self._since_s
        self._since_s = now_s

    def _timed(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        @functools.wraps(function)
        def timed(*arguments: Any, **named: Any) -> Any:
            parts = self._parts
            # Calls within a part, recursive ones included, are already counted.
            if parts[-1] == part:
                return function(*arguments, **named)
            self._lap()
            self.entered[part] += 1
            parts.append(part)
            try:
                return function(*arguments, **named)
            finally:
                self._lap()
                parts.pop()

        return timed
