"""How long FCL takes to look at one configuration of the arm among blocks.

By the processor's time of the thread: one look in a hundred would else be one that had to wait for
other processes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nsrm_harness import domain as domains
from nsrm_harness.data.programs import sample_blocks
from nsrm_harness.data.seeds import generator
from nsrm_harness.evaluation.manipulation_trials.speed.episode import SpeedError
from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.collision import CollisionChecker
from nsrm_harness.manipulation.grasps import pointing_down
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.layout import WORK_SPACE, LayoutError, sample_layout

GOAL_S = 0.001
"""A look is to take no longer."""
BLOCKS = 10
SCENES, CONFIGURATIONS = 10, 100
"""So many free configurations are looked at in each of so many scenes."""
FINGERTIPS_M = (0.01, 0.20)
"""How high above the table they are over the work space."""
MAX_TRIES = 1000
"""Of a scene, and of a free configuration."""

Draw = Callable[[np.random.Generator, Kinematics], Joints | None]


@dataclass(frozen=True, eq=False)
class CheckTimes:
    """The times of many looks, seconds.

    * `where`: one of `PLACES`
    * `holds`: whether the hand holds a block
    * `touches_s`: whether anything is too near, as the sampling planner asks
    * `free_s`: how far the arm may move until something is, as is asked along trajectories
    """

    where: str
    holds: bool
    touches_s: NDArray[np.float64]
    free_s: NDArray[np.float64]


def _anywhere(rng: np.random.Generator, _: Kinematics) -> Joints:
    return rng.uniform(panda.LOWEST_RAD, panda.HIGHEST_RAD)


def _over_blocks(rng: np.random.Generator, kinematics: Kinematics) -> Joints | None:
    x, y = rng.uniform(WORK_SPACE.min[:2], WORK_SPACE.max[:2])
    hand = pointing_down(float(x), float(y), rng.uniform(*FINGERTIPS_M), rng.uniform(-1.5, 1.5))
    return kinematics.joints(hand, panda.READY_RAD)


PLACES: dict[str, Draw] = {
    "all joints anywhere": _anywhere,
    "hand among or above the blocks": _over_blocks,
}
"""How a configuration is drawn, by title."""


def looks(seed: int) -> list[CheckTimes]:
    """Times in random free configurations, each place with and without a block in the hand."""
    kinematics = Kinematics()
    found: dict[tuple[str, bool], list[tuple[float, float]]] = {}
    for scene in range(SCENES):
        rng = generator(seed, "arm_checks", scene)
        objects, held = _scene(rng)
        for where, draw in PLACES.items():
            for in_hand in (None, held):
                guard = CollisionChecker(kinematics, objects, in_hand)
                opening_m = panda.MAX_OPENING_M if in_hand is None else in_hand.edges_m[1]
                times = found.setdefault((where, in_hand is not None), [])
                for joints in _free(rng, kinematics, guard, opening_m, draw):
                    times.append(_times(guard, joints, opening_m))
    return [CheckTimes(where, holds, *np.array(times).T) for (where, holds), times in found.items()]


def _times(guard: CollisionChecker, joints: Joints, opening_m: float) -> tuple[float, float]:
    began_s = time.thread_time()
    guard.touches(joints, opening_m)
    between_s = time.thread_time()
    guard.free_m(joints, opening_m)
    return between_s - began_s, time.thread_time() - between_s


def _free(
    rng: np.random.Generator,
    kinematics: Kinematics,
    guard: CollisionChecker,
    opening_m: float,
    draw: Draw,
) -> Iterator[Joints]:
    """Configurations in which nothing is too near to anything."""
    for _ in range(CONFIGURATIONS):
        for _ in range(MAX_TRIES):
            joints = draw(rng, kinematics)
            if joints is not None and guard.touches(joints, opening_m) is None:
                yield joints
                break
        else:
            raise SpeedError(f"no free configuration in {MAX_TRIES} tries: another --seed")


def _scene(rng: np.random.Generator) -> tuple[dict[str, Cuboid], Cuboid]:
    """What stands on the table, and what is held, in the hand's frame."""
    domain = domains.load()
    for _ in range(MAX_TRIES):
        *standing, held = sample_blocks(rng, domain, BLOCKS + 1)
        try:
            poses = sample_layout(rng, standing)
        except LayoutError:
            continue
        objects = {
            f"object {number}": Cuboid(pose, block.edges_m)
            for number, (block, pose) in enumerate(zip(standing, poses, strict=True), start=1)
        }
        return objects, _in_hand(held)
    raise SpeedError(f"no room for {BLOCKS} blocks in {MAX_TRIES} scenes: another --seed")


def _in_hand(block: Block) -> Cuboid:
    """Held at its middle; the hand points down, its z is the block's turned about."""
    return Cuboid(Pose((0.0, 0.0, panda.FINGERTIP_M)), block.edges_m)
