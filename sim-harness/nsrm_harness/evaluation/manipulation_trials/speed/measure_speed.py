"""All that is measured, one after the other: nothing of it runs beside anything else of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass

from nsrm_harness.common.workers import LocalProcesses, RayCluster
from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.speed.checks import CheckTimes, looks
from nsrm_harness.evaluation.manipulation_trials.speed.episode import (
    SpeedEpisode,
    SpeedError,
    mixed,
)
from nsrm_harness.evaluation.manipulation_trials.speed.profile import Profiled, profiled
from nsrm_harness.evaluation.manipulation_trials.speed.throughput import Measured, measure

RAY_WORKERS = 2


@dataclass(frozen=True)
class Speed:
    """What was measured.

    * `processors`, `load`: of the machine, and how many processes waited for them when it began
    * `throughput`: by one process first
    """

    processors: int
    load: float
    throughput: tuple[Measured, ...]
    profile: tuple[Profiled, ...]
    looks: tuple[CheckTimes, ...]


def run(
    count: int, seed: int, jobs: Sequence[int], *, with_ray: bool, done: Callable[[], object]
) -> Speed:
    """Measures `count` episodes by each kind of workers.

    * `jobs`: numbers of processes, besides one
    * `done`: is called after each episode, `rounds` times `count` in all

    Raises `SpeedError`, and `WorkersError` where Ray is asked for and can't be had.
    """
    load, _, _ = os.getloadavg()
    episodes = mixed(count, seed)
    # Ray first, as it may be missing.
    on_ray = _on_ray(episodes, done) if with_ray else ()
    throughput = (*(_by_processes(each, episodes, done) for each in _counts(jobs)), *on_ray)
    profile = _profile(episodes, done)
    ((_, times),) = LocalProcesses(1).each(looks, [("looks", (seed,))])
    for title, ended in (
        *((measured.title, measured.ended) for measured in throughput),
        ("without the profile", [each.plain for each in profile]),
        ("with the profile", [each.profiled for each in profile]),
    ):
        check_same(title, ended, throughput[0].ended)
    return Speed(os.cpu_count() or 1, load, throughput, profile, tuple(times))


def rounds(jobs: Sequence[int], *, with_ray: bool) -> int:
    """How often all episodes are carried out."""
    return len(_counts(jobs)) + with_ray + 1


def check_same(
    title: str, ended: Iterable[EpisodeResult], expected: Iterable[EpisodeResult]
) -> None:
    """Raises `SpeedError` unless the same episodes ended the same."""
    for each, other in zip(ended, expected, strict=True):
        if each != other:
            raise SpeedError(
                f"{title}: {each.row} {each.index} ended otherwise than by one process: a fault, "
                "as an episode is the same in any process; compare both by harness trials "
                f"--row {each.row}"
            )


def _counts(jobs: Sequence[int]) -> list[int]:
    return sorted({1, *jobs})


def _on_ray(episodes: Sequence[SpeedEpisode], done: Callable[[], object]) -> tuple[Measured]:
    title = f"Ray, {RAY_WORKERS} workers"
    return (measure(title, lambda: RayCluster("local", RAY_WORKERS), episodes, done),)


def _by_processes(
    count: int, episodes: Sequence[SpeedEpisode], done: Callable[[], object]
) -> Measured:
    title = "1 process" if count == 1 else f"{count} processes"
    return measure(title, lambda: nullcontext(LocalProcesses(count)), episodes, done)


def _profile(episodes: Sequence[SpeedEpisode], done: Callable[[], object]) -> tuple[Profiled, ...]:
    """In one process; which of the two comes first changes from one episode to the next."""
    tasks = ((number, (episode, number % 2 == 0)) for number, episode in enumerate(episodes))
    found = {}
    for number, each in LocalProcesses(1).each(profiled, tasks):
        found[number] = each
        done()
    return tuple(found[number] for number in sorted(found))
