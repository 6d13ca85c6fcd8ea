"""Scenes of several kinds, seen by a camera with exactly known pose and intrinsics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from nsrm_harness.data.disturbance import UNDISTURBED, Disturbance
from nsrm_harness.data.moves import Arrangement, Move, target
from nsrm_harness.data.programs import sample_blocks
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.detector.scenes import Picture, with_noise
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.simulation.layout import MAX_YAW_RAD, LayoutError, sample_layout
from nsrm_harness.simulation.render import Light, Renderer, open_renderer
from nsrm_harness.simulation.segmentation import segmented_image
from nsrm_harness.simulation.world import World

ONTO = 0.7
"""Share of the moves that put a block onto another one, if possible."""
STREAM = "miscalibration"


@dataclass(frozen=True)
class SceneKind:
    """A kind of scenes. Blocks may hide one another, also completely.

    * `objects`: smallest and largest number of blocks; `moves`: largest number of moved ones
    * `yaw_rad`: largest rotation of the blocks before the moves
    * `noise_m`, `dropout`: noise on the detector's depth, see `with_noise`
    """

    name: str
    objects: tuple[int, int]
    moves: int
    yaw_rad: float = MAX_YAW_RAD
    disturbance: Disturbance = UNDISTURBED
    noise_m: float = 0.0
    dropout: float = 0.0


KINDS = (
    SceneKind("as in training", (4, 6), 2),
    SceneKind("towers of many blocks", (2, 12), 8),
    SceneKind("few blocks", (2, 4), 3),
    SceneKind("turned by up to 45 degrees", (3, 5), 0, yaw_rad=math.radians(45.0)),
    SceneKind(
        "camera elsewhere, other light",
        (4, 8),
        4,
        disturbance=Disturbance(camera_m=0.02, camera_deg=2.0, light=0.3, color=0.2),
    ),
    SceneKind("noise of 2 mm on depth", (4, 8), 4, noise_m=0.002, dropout=0.01),
)


def scenes(kind: SceneKind, domain: Domain, count: int, seed: int) -> Iterator[Picture]:
    """Scenes of a kind, each with its own random generator."""
    pictures = _scenes(kind, domain, count, seed)
    if kind.noise_m > 0.0:
        return with_noise(pictures, kind.noise_m, kind.dropout, seed)
    return pictures


def _scenes(kind: SceneKind, domain: Domain, count: int, seed: int) -> Iterator[Picture]:
    first = count * KINDS.index(kind)
    with closing(open_renderer("auto")) as drawing, World() as world:
        for index in range(first, first + count):
            yield _scene(kind, domain, world, drawing, generator(seed, STREAM, index))


def _scene(
    kind: SceneKind, domain: Domain, world: World, drawing: Renderer, rng: np.random.Generator
) -> Picture:
    while not _arrange(kind, domain, world, rng):
        pass
    camera = kind.disturbance.moved(default_camera(), rng)
    light = kind.disturbance.lit(Light.sample(rng), rng)
    seen = segmented_image(drawing.render(world, camera, light))
    return Picture(seen.rgb, seen.depth, camera, seen.boxes, seen.depths)


def _arrange(kind: SceneKind, domain: Domain, world: World, rng: np.random.Generator) -> bool:
    """Puts blocks on the table and moves some; returns whether they had room and stand."""
    blocks = sample_blocks(rng, domain, int(rng.integers(kind.objects[0], kind.objects[1] + 1)))
    try:
        poses = sample_layout(rng, blocks, max_yaw_rad=kind.yaw_rad)
    except LayoutError:
        return False
    world.reset()
    world.spawn(kind.disturbance.painted(tuple(blocks), rng), poses)
    if not world.settle().at_rest:
        return False
    arrangement = Arrangement.on_table(blocks, poses)
    for _ in range(int(rng.integers(kind.moves + 1))):
        move = _draw(arrangement.moves(domain), rng)
        if move is None:
            break
        now = [pose for _, pose in sorted(world.poses().items())]
        world.place(move.moved + 1, target(move, blocks, now))
        if not world.settle().at_rest:
            return False
        arrangement = arrangement.after(move)
    return True


def _draw(moves: list[Move], rng: np.random.Generator) -> Move | None:
    onto = [move for move in moves if move.action.direction is None]
    among = onto if onto and rng.random() < ONTO else moves
    return among[int(rng.integers(len(among)))] if among else None
