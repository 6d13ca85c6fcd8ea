"""What differs from what training showed: where the camera stands, light, colours, depth."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.pose import Quaternion, Vector3
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.render import Frame, Light


@dataclass(frozen=True)
class Disturbance:
    """Sizes, each 0 for none; what is drawn is uniform within them unless said otherwise.

    The camera is calibrated where it stands: an episode's camera is the one that took its
    pictures.
    """

    camera_m: float = 0.0
    """The camera stands so far away from its place at most, along each axis."""
    camera_deg: float = 0.0
    """It is turned by so many degrees at most, about any axis."""
    light: float = 0.0
    """The lamp's strength, the ambient's, and the strength of each colour of the lamp are off by
    such a share at most."""
    color: float = 0.0
    """Red, green and blue of each block are off by such a share at most."""
    depth_m: float = 0.0
    """Standard deviation of white, normal noise on depth, metres."""

    def moved(self, camera: Camera, rng: np.random.Generator) -> Camera:
        """The camera where it stands."""
        shift = rng.uniform(-1.0, 1.0, 3) * self.camera_m
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        angle = math.radians(float(rng.uniform(-1.0, 1.0)) * self.camera_deg)
        x, y, z = (float(value) for value in np.add(camera.position, shift))
        turn = _about(axis, angle)
        return replace(camera, position=(x, y, z), orientation=_times(turn, camera.orientation))

    def lit(self, light: Light, rng: np.random.Generator) -> Light:
        """The light as it is."""
        factors = 1.0 + rng.uniform(-1.0, 1.0, 5) * self.light
        ambient, diffuse = light.ambient * factors[0], light.diffuse * factors[1]
        color = _three(np.multiply(light.color, factors[2:]))
        return replace(light, ambient=float(ambient), diffuse=float(diffuse), color=color)

    def painted(self, blocks: tuple[Block, ...], rng: np.random.Generator) -> tuple[Block, ...]:
        """The blocks in the colours that they have."""
        factors = 1.0 + rng.uniform(-1.0, 1.0, (len(blocks), 3)) * self.color
        return tuple(
            replace(block, rgb=_three(np.clip(np.multiply(block.rgb, factor), 0.0, 1.0)))
            for block, factor in zip(blocks, factors, strict=True)
        )

    def measured(self, frame: Frame, rng: np.random.Generator) -> Frame:
        """The picture with the depth that is measured."""
        if self.depth_m == 0.0:
            return frame
        noise = rng.normal(0.0, self.depth_m, frame.depth.shape)
        return replace(frame, depth=(frame.depth + noise).astype(np.float32))


UNDISTURBED = Disturbance()


def _about(axis: NDArray[np.float64], angle: float) -> Quaternion:
    x, y, z = (float(value) * math.sin(angle / 2) for value in axis)
    return (x, y, z, math.cos(angle / 2))


def _times(a: Quaternion, b: Quaternion) -> Quaternion:
    """The turn `b`, then `a`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _three(values: NDArray[np.float64]) -> Vector3:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
