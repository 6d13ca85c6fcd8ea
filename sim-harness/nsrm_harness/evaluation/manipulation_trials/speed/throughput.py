"""Measures how many episodes per minute workers run, without the time that they take to start."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from nsrm_harness.common.workers import Workers
from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.speed.episode import (
    SpeedEpisode,
    SpeedError,
    warm_up,
)

NAP_S = 0.05
"""Interval at which a warm worker waits for the others."""
MAX_START_S = 300.0
"""Timeout for the start of all workers."""


@dataclass(frozen=True)
class Measured:
    """Episodes run by some workers.

    * `title`: name of the workers
    * `start_s`: time until each of them had run its first episode, which is not counted
    * `work_s`: time from then until the last episode ended
    * `late`: number of workers that only started during `work_s`
    """

    title: str
    count: int
    ended: tuple[EpisodeResult, ...]
    start_s: float
    work_s: float
    late: int

    @property
    def episodes_a_minute(self) -> float:
        """Episodes run per minute."""
        return 60 * len(self.ended) / self.work_s

    @property
    def sub_goals(self) -> int:
        """Number of sub-goals reached."""
        return sum(len(each.tries) for each in self.ended)

    @property
    def sub_goals_a_minute(self) -> float:
        """Sub-goals reached per minute."""
        return 60 * self.sub_goals / self.work_s


def measure(
    title: str,
    workers: Callable[[], AbstractContextManager[Workers]],
    episodes: Sequence[SpeedEpisode],
    done: Callable[[], object],
) -> Measured:
    """Has workers run episodes.

    * `workers`: starts them
    * `done`: called after each episode

    Raises `SpeedError` if they do not start.
    """
    began_s = time.monotonic()
    with workers() as started:
        start = _Start(started.count, began_s + MAX_START_S)
        ended: dict[int, EpisodeResult] = {}
        late = 0
        for key, result in started.each(_work, start.then(episodes)):
            if key is None or result.ended is None:
                start.warm.add(result.process)
                continue
            ended[key] = result.ended
            late += result.was_cold
            done()
        ended_s = time.monotonic()
    return Measured(
        title,
        started.count,
        tuple(ended[number] for number in range(len(episodes))),
        start.ended_s - began_s,
        ended_s - start.ended_s,
        late,
    )


@dataclass(frozen=True)
class _Result:
    process: int
    was_cold: bool
    ended: EpisodeResult | None


class _Start:
    """Hands out warm-ups until all workers have run one.

    * `warm`: the processes that have run one
    """

    def __init__(self, count: int, until_s: float) -> None:
        self._count, self._until_s = count, until_s
        self.warm: set[int] = set()
        self.ended_s = 0.0

    def then(
        self, episodes: Sequence[SpeedEpisode]
    ) -> Iterator[tuple[int | None, tuple[SpeedEpisode, bool]]]:
        """Warm-ups, then the episodes."""
        while len(self.warm) < self._count:
            if time.monotonic() > self._until_s:
                raise SpeedError(
                    f"{len(self.warm)} of {self._count} workers have started after "
                    f"{MAX_START_S:.0f} s: use fewer --jobs, or run less beside"
                )
            yield None, (episodes[0], True)
        self.ended_s = time.monotonic()
        for number, episode in enumerate(episodes):
            yield number, (episode, False)


def _work(episode: SpeedEpisode, warms_up_alone: bool) -> _Result:
    was_cold = warm_up(episode)
    ended = None
    if not warms_up_alone:
        ended = episode.carry_out()
    elif not was_cold:
        time.sleep(NAP_S)
    return _Result(os.getpid(), was_cold, ended)
