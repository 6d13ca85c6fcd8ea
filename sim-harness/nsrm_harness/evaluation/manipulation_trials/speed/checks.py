"""Measures how long it takes to check one configuration of the arm among blocks.

Times are the thread's processor time: in wall time, one check in a hundred would include waiting
for other processes.
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
"""Goal for the time of one check."""
BLOCKS = 10
SCENES, CONFIGURATIONS = 10, 100
"""Number of scenes, and of free configurations that are checked in each."""
FINGERTIPS_M = (0.01, 0.20)
"""Lowest and highest fingertips above the table in the workspace."""
MAX_TRIES = 1000
"""Largest number of draws for a scene, and for a free configuration."""

Draw = Callable[[np.random.Generator, Kinematics], Joints | None]


@dataclass(frozen=True, eq=False)
class CheckTimes:
    """The times of many checks, in seconds.

    * `where`: one of `PLACES`
    * `holds`: whether the hand holds a block
    * `touches_s`: of the query whether anything is too near, which the sampling planner makes
    * `free_s`: of the query for the distance, which is made along trajectories
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
    "random joints": _anywhere,
    "hand among or above the blocks": _over_blocks,
}
"""How configurations are drawn, by title."""


def looks(seed: int) -> list[CheckTimes]:
    """Times checks in random free configurations, with and without a block in the hand."""
    kinematics = Kinematics()
    found: dict[tuple[str, bool], list[tuple[float, float]]] = {}
    for scene in range(SCENES):
        rng = generator(seed, "arm_checks", scene)
        objects, held = _scene(rng)
        for where, draw in PLACES.items():
            for in_hand in (None, held):
                checker = CollisionChecker(kinematics, objects, in_hand)
                opening_m = panda.MAX_OPENING_M if in_hand is None else in_hand.edges_m[1]
                times = found.setdefault((where, in_hand is not None), [])
                for joints in _free(rng, kinematics, checker, opening_m, draw):
                    times.append(_times(checker, joints, opening_m))
    return [CheckTimes(where, holds, *np.array(times).T) for (where, holds), times in found.items()]


def _times(checker: CollisionChecker, joints: Joints, opening_m: float) -> tuple[float, float]:
    began_s = time.thread_time()
    checker.touches(joints, opening_m)
    between_s = time.thread_time()
    checker.free_m(joints, opening_m)
    return between_s - began_s, time.thread_time() - between_s


def _free(
    rng: np.random.Generator,
    kinematics: Kinematics,
    checker: CollisionChecker,
    opening_m: float,
    draw: Draw,
) -> Iterator[Joints]:
    """Collision-free configurations."""
    for _ in range(CONFIGURATIONS):
        for _ in range(MAX_TRIES):
            joints = draw(rng, kinematics)
            if joints is not None and checker.touches(joints, opening_m) is None:
                yield joints
                break
        else:
            raise SpeedError(f"no free configuration in {MAX_TRIES} tries: use another --seed")


def _scene(rng: np.random.Generator) -> tuple[dict[str, Cuboid], Cuboid]:
    """The objects on the table, and the held block in the hand's frame."""
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
    raise SpeedError(f"no room for {BLOCKS} blocks in {MAX_TRIES} scenes: use another --seed")


def _in_hand(block: Block) -> Cuboid:
    """The block held at its middle. The hand points down: its z axis is opposite to the block's."""
    return Cuboid(Pose((0.0, 0.0, panda.FINGERTIP_M)), block.edges_m)
