"""Runs all speed measurements, one after the other."""

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
    """The results of the measurements.

    * `processors`, `load`: number of processors of the machine, and its load at the start
    * `throughput`: starts with one process
    """

    processors: int
    load: float
    throughput: tuple[Measured, ...]
    profile: tuple[Profiled, ...]
    looks: tuple[CheckTimes, ...]


def run(
    count: int, seed: int, jobs: Sequence[int], *, with_ray: bool, done: Callable[[], object]
) -> Speed:
    """Measures `count` episodes with each kind of workers.

    * `jobs`: numbers of processes, in addition to one
    * `done`: called after each episode, `rounds` times `count` in all

    Raises `SpeedError`, and `WorkersError` if Ray is requested but not available.
    """
    load, _, _ = os.getloadavg()
    episodes = mixed(count, seed)
    # Ray first because it may be missing.
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
    """How often all episodes are run."""
    return len(_counts(jobs)) + with_ray + 1


def check_same(
    title: str, ended: Iterable[EpisodeResult], expected: Iterable[EpisodeResult]
) -> None:
    """Raises `SpeedError` unless the same episodes ended the same."""
    for each, other in zip(ended, expected, strict=True):
        if each != other:
            raise SpeedError(
                f"{title}: {each.row} {each.index} ended differently than in one process, which "
                "is a fault: an episode must be the same in any process; compare both with "
                f"harness trials --row {each.row}"
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
    """Profiles in one process; which of the two runs comes first alternates between episodes."""
    tasks = ((number, (episode, number % 2 == 0)) for number, episode in enumerate(episodes))
    found = {}
    for number, each in LocalProcesses(1).each(profiled, tasks):
        found[number] = each
        done()
    return tuple(found[number] for number in sorted(found))
