"""Scenes for tests of the arm, and helpers that pass on its motions."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from world_scenes import DOMAIN

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.grasps import pointing_down
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.manipulation.pick_and_place import PickAndPlace, PickAndPlacePlanner
from nsrm_harness.manipulation.retries import Look
from nsrm_harness.perception.observer import Observer
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.blocks import block_from_attributes
from nsrm_harness.simulation.render import Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera

TESTS = Path(__file__).parent

PLACED_M = 0.001
STAYED_M = 0.0005
HOME_RAD = 0.02

KINEMATICS = Kinematics()


def above(x: float, y: float, z: float) -> Joints:
    """With the fingertips there, from above."""
    joints = KINEMATICS.joints(pointing_down(x, y, z, 0.0), panda.READY_RAD)
    assert joints is not None
    return joints


BESIDE = Pose.upright(0.5, -0.2, 0.02)
ON_THE_LARGE_ONE = Pose.upright(0.5, 0.1, 0.07)

HEMMED_IN = tuple(
    ("small", 0.5 + x, y, 0.0, 0.0)
    for x, y in ((0.048, 0.0), (-0.048, 0.0), (0.0, 0.048), (0.0, -0.048))
)
"""8 mm from a small block in the middle: a finger is thicker."""


def put(world: ArmWorld, *blocks: tuple[str, float, float, float, float]) -> None:
    """Each of a size at x, y and a height of its foot, turned by a yaw; named by its number."""
    colors = itertools.cycle(("red", "green", "blue", "yellow", "magenta", "cyan"))
    made = [
        block_from_attributes(DOMAIN, {"color": color, "size": size})
        for color, (size, *_) in zip(colors, blocks, strict=False)
    ]
    poses = [
        Pose.upright(x, y, foot + block.edges_m[2] / 2, yaw)
        for block, (_, x, y, foot, yaw) in zip(made, blocks, strict=True)
    ]
    world.spawn(made, poses)
    assert world.settle().at_rest


def three(world: ArmWorld) -> None:
    """A small block, a large one and another small one."""
    put(world, ("small", 0.45, -0.1, 0, 0.3), ("lego", 0.5, 0.1, 0, -0.2), ("small", 0.6, 0, 0, 0))


def known(world: ArmWorld) -> Look:
    """All blocks where they are."""
    return lambda: {
        str(placed.id): Cuboid(placed.pose, placed.block.edges_m) for placed in world.placed()
    }


def pictured(world: ArmWorld, renderer: Renderer) -> Look:
    """All blocks where pictures show them."""
    observer = Observer(SimulatedCamera(renderer, world, default_camera()))
    names = {
        number: str(world.nearest(cuboid.pose.position)[0])
        for number, cuboid in observer.look().cuboids.items()
    }

    def look() -> Mapping[str, Cuboid]:
        cuboids = observer.look().cuboids
        return {names.get(number, f"new {number}"): cuboids[number] for number in cuboids}

    return look


def at_home(world: ArmWorld) -> bool:
    return float(np.abs(world.joints() - panda.READY_RAD).max()) < HOME_RAD


class Noting(PickAndPlacePlanner):
    """Keeps what it planned."""

    def __init__(self) -> None:
        super().__init__()
        self.carries: list[PickAndPlace] = []

    def carry(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints, **how: bool
    ) -> PickAndPlace:
        self.carries.append(super().carry(objects, name, goal, begin, **how))
        return self.carries[-1]


class Through:
    """Passes everything on to an arm in its world; what meddles with it is derived from it."""

    def __init__(self, world: ArmWorld) -> None:
        self.world = world

    @property
    def tick_s(self) -> float:
        return self.world.tick_s

    def drive(self, joints: Joints, speeds: Joints) -> None:
        self.world.drive(joints, speeds)

    def grip(self, opening_m: float, force_n: float) -> None:
        self.world.grip(opening_m, force_n)

    def joints(self) -> Joints:
        return self.world.joints()

    def opening_m(self) -> float:
        return self.world.opening_m()

    def tick(self) -> None:
        self.world.tick()


class Still(Through):
    """May be asked where it is, and not be moved."""

    def drive(self, joints: Joints, speeds: Joints) -> None:
        pytest.fail("it was driven")

    def grip(self, opening_m: float, force_n: float) -> None:
        pytest.fail("its fingers were moved")

    def tick(self) -> None:
        pytest.fail("time went on")


class Numb(Through):
    """Its fingers open as they are told to, but hardly close, from and to events."""

    CLOSED_BY_M = 0.0015

    def __init__(self, world: ArmWorld, until: str = "", since: str = "") -> None:
        super().__init__(world)
        self._until, self._since, self.is_numb = until, since, not since
        self._open_m = panda.MAX_OPENING_M

    def mark(self, event: str) -> None:
        self.is_numb = (self.is_numb or event == self._since) and event != self._until

    def grip(self, opening_m: float, force_n: float) -> None:
        if opening_m > 0.0:
            self._open_m = opening_m
        elif self.is_numb:
            opening_m = self._open_m - self.CLOSED_BY_M
        super().grip(opening_m, force_n)
