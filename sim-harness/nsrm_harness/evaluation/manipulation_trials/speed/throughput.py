"""How many episodes a minute workers carry out, without the time that they take to start."""

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
"""A warm worker waits so long at a time for the others."""
MAX_START_S = 300.0
"""Of all workers' start."""


@dataclass(frozen=True)
class Measured:
    """Episodes by some workers.

    * `title`: of the workers
    * `start_s`: until each of them had done its first episode, which is not counted
    * `work_s`: from then until the last episode ended
    * `late`: of the workers, those that had done none before, and started within that time
    """

    title: str
    count: int
    ended: tuple[EpisodeResult, ...]
    start_s: float
    work_s: float
    late: int

    @property
    def episodes_a_minute(self) -> float:
        """Carried out."""
        return 60 * len(self.ended) / self.work_s

    @property
    def sub_goals(self) -> int:
        """That were reached."""
        return sum(len(each.tries) for each in self.ended)

    @property
    def sub_goals_a_minute(self) -> float:
        """Reached."""
        return 60 * self.sub_goals / self.work_s


def measure(
    title: str,
    workers: Callable[[], AbstractContextManager[Workers]],
    episodes: Sequence[SpeedEpisode],
    done: Callable[[], object],
) -> Measured:
    """Has workers carry episodes out.

    * `workers`: starts them
    * `done`: is called after each episode

    Raises `SpeedError` if they don't start.
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
    """Hands warm-ups out until all workers have done one.

    * `warm`: the processes that have
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
                    f"{MAX_START_S:.0f} s: fewer --jobs, or less other work beside"
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
