"""Where the time of an episode goes."""

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
from nsrm_harness.manipulation.follow import Follower
from nsrm_harness.manipulation.kinematics import Kinematics
from nsrm_harness.perception.observer import Observer
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render.gl import GlRenderer
from nsrm_harness.simulation.render.tiny import TinyRenderer
from nsrm_harness.simulation.world import World

_FUNCTIONS: dict[str, tuple[tuple[type | ModuleType, tuple[str, ...]], ...]] = {
    "rendering": ((GlRenderer, ("render",)), (TinyRenderer, ("render",))),
    "perception": ((Observer, ("look",)),),
    "model": ((Follower, ("_plan",)),),
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
    "rendering": "pictures drawn",
    "perception": "detector, tracker, boxes in space",
    "model": "the model: crops, plan",
    "kinematics": "inverse kinematics",
    "collision": "collision checks (FCL)",
    "sampling": "sampling planner (OMPL) without its checks",
    "planning": "planning besides: grasps, support, order",
    "timing": "timing (Ruckig), places on trajectories",
    "physics": "steps of physics (PyBullet)",
    "motors": "joints and fingers told and read",
    "world": "the simulated world made",
    "judge": "the judge, in each step of physics",
    REST: "rest",
}
"""Each with its title, in the order in which it is told."""

SITES = tuple(
    Site(owner, name, part)
    for part, owners in _FUNCTIONS.items()
    for owner, names in owners
    for name in names
)
"""All functions that are timed. What they call that is not among them is theirs."""


@dataclass(frozen=True)
class EpisodeTime:
    """How long something took: on the clock, and of the processor's time."""

    clock_s: float
    processor_s: float


@dataclass(frozen=True)
class Profiled:
    """An episode with and without the stopwatch.

    * `plain`, `profiled`: how it ended without and with it
    * `plain_took`, `profiled_took`: how long it took
    * `seconds`: of each part, on the clock; they add up to those of `profiled_took`
    * `entered`: how often it was called from another part
    """

    plain: EpisodeResult
    profiled: EpisodeResult
    plain_took: EpisodeTime
    profiled_took: EpisodeTime
    seconds: dict[str, float]
    entered: dict[str, int]


def profiled(episode: SpeedEpisode, plain_first: bool) -> Profiled:
    """Carries an episode out twice.

    * `plain_first`: what comes second finds the processor's memory warm, so the order is to
      change from one episode to the next
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
