"""Profiles where the time of an episode goes."""

from __future__ import annotations

import time
from dataclasses import dataclass
from types import ModuleType

from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementJudge
from nsrm_harness.evaluation.manipulation_trials.speed.episode import SpeedEpisode, warm_up
from nsrm_harness.evaluation.manipulation_trials.speed.stopwatch import REST, Site, Stopwatch
from nsrm_harness.manipulation import paths, pick_and_place, retries, trajectory
from nsrm_harness.manipulation.collision import CollisionChecker
from nsrm_harness.manipulation.kinematics import Kinematics
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.perception.observer import Observer
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render.gl import GlRenderer
from nsrm_harness.simulation.render.tiny import TinyRenderer
from nsrm_harness.simulation.world import World

_FUNCTIONS: dict[str, tuple[tuple[type | ModuleType, tuple[str, ...]], ...]] = {
    "rendering": ((GlRenderer, ("render",)), (TinyRenderer, ("render",))),
    "perception": ((Observer, ("look",)),),
    "model": ((ClosedLoop, ("_poll", "_tell")),),
    "kinematics": ((Kinematics, ("joints",)),),
    "collision": ((CollisionChecker, ("__init__", "along", "touches", "nearest")),),
    "sampling": ((paths, ("_sampled",)),),
    "planning": (
        (pick_and_place.PickAndPlacePlanner, ("carry",)),
        (retries, ("plan_relocations", "plan_regrasp")),
    ),
    "timing": (
        (trajectory.Straight, ("__init__", "at")),
        (trajectory.Along, ("__init__", "at")),
        (trajectory.Backwards, ("__init__", "at")),
    ),
    "physics": ((ArmWorld, ("tick",)), (World, ("settle",))),
    "motors": ((ArmWorld, ("drive", "grip", "joints", "opening_m")),),
    "world": ((ArmWorld, ("__init__",)), (World, ("spawn", "close"))),
    "judge": ((PlacementJudge, ("__init__", "begin", "tick", "end", "stands")),),
}

PARTS: dict[str, str] = {
    "rendering": "rendering",
    "perception": "detector, tracker, cuboids",
    "model": "the model: crops, plan",
    "kinematics": "inverse kinematics",
    "collision": "collision checks",
    "sampling": "sampling planner (OMPL) without its collision checks",
    "planning": "other planning: grasps, support, order",
    "timing": "trajectories (Ruckig)",
    "physics": "physics steps (PyBullet)",
    "motors": "joint and finger commands and states",
    "world": "creating the simulated world",
    "judge": "the judge, in each physics step",
    REST: "rest",
}
"""Titles of the parts, in the order of the report."""

SITES = tuple(
    Site(owner, name, part)
    for part, owners in _FUNCTIONS.items()
    for owner, names in owners
    for name in names
)
"""All timed functions. The time of untimed functions counts for their caller."""


@dataclass(frozen=True)
class EpisodeTime:
    """How long something took, in wall time and in processor time."""

    clock_s: float
    processor_s: float


@dataclass(frozen=True)
class Profiled:
    """An episode run with and without stopwatches.

    * `plain`, `profiled`: how it ended without and with them
    * `plain_took`, `profiled_took`: how long it took without and with them
    * `seconds`: wall time of each part; they add up to that of `profiled_took`
    * `entered`: how often each part was called from another one
    """

    plain: EpisodeResult
    profiled: EpisodeResult
    plain_took: EpisodeTime
    profiled_took: EpisodeTime
    seconds: dict[str, float]
    entered: dict[str, int]


def profiled(episode: SpeedEpisode, plain_first: bool) -> Profiled:
    """Runs an episode twice.

    * `plain_first`: the second run finds warm processor caches, so alternate the order between
      episodes
    """
    warm_up(episode)
    watch = Stopwatch()
    if plain_first:
        plain, plain_took = _plain(episode)
        ended, processor_s = _watched(episode, watch)
    else:
        ended, processor_s = _watched(episode, watch)
        plain, plain_took = _plain(episode)
    return Profiled(
        plain,
        ended,
        plain_took,
        EpisodeTime(watch.whole_s, processor_s),
        {part: watch.seconds[part] for part in PARTS},
        {part: watch.entered[part] for part in PARTS},
    )


def _plain(episode: SpeedEpisode) -> tuple[EpisodeResult, EpisodeTime]:
    began_s, began_processor_s = time.perf_counter(), time.process_time()
    ended = episode.carry_out()
    took = EpisodeTime(time.perf_counter() - began_s, time.process_time() - began_processor_s)
    return ended, took


def _watched(episode: SpeedEpisode, watch: Stopwatch) -> tuple[EpisodeResult, float]:
    began_s = time.process_time()
    with watch.watching(SITES):
        ended = episode.carry_out()
    return ended, time.process_time() - began_s
