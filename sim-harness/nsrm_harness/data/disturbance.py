"""Disturbances: differences from the training data in camera pose, light, colours and depth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.render import Frame, Light


@dataclass(frozen=True)
class Disturbance:
    """The sizes of the disturbances, each 0 for none; values are uniform within them unless stated
    otherwise.

    The displaced camera is calibrated: an episode's camera is the one that took its images.
    """

    camera_m: float = 0.0
    """Largest displacement of the camera along each axis."""
    camera_deg: float = 0.0
    """Largest rotation of the camera about any axis, degrees."""
    light: float = 0.0
    """Largest relative change of the lamp's intensity, of the ambient light, and of each colour of
    the lamp."""
    color: float = 0.0
    """Largest relative change of red, green and blue of each block."""
    depth_m: float = 0.0
    """Standard deviation of white Gaussian noise on depth, metres."""

    def moved(self, camera: Camera, rng: np.random.Generator) -> Camera:
        """The displaced camera."""
        shift = rng.uniform(-1.0, 1.0, 3) * self.camera_m
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        angle_deg = float(rng.uniform(-1.0, 1.0)) * self.camera_deg
        x, y, z, w = map(float, Rotation.from_rotvec(angle_deg * axis, degrees=True).as_quat())
        turned = Pose((0.0, 0.0, 0.0), (x, y, z, w)) @ camera.pose
        position = _three(np.add(camera.position, shift))
        return replace(camera, position=position, orientation=turned.orientation)

    def lit(self, light: Light, rng: np.random.Generator) -> Light:
        """The changed light."""
        factors = 1.0 + rng.uniform(-1.0, 1.0, 5) * self.light
        ambient, diffuse = light.ambient * factors[0], light.diffuse * factors[1]
        color = _three(np.multiply(light.color, factors[2:]))
        return replace(light, ambient=float(ambient), diffuse=float(diffuse), color=color)

    def painted(self, blocks: tuple[Block, ...], rng: np.random.Generator) -> tuple[Block, ...]:
        """The blocks with changed colours."""
        factors = 1.0 + rng.uniform(-1.0, 1.0, (len(blocks), 3)) * self.color
        return tuple(
            replace(block, rgb=_three(np.clip(np.multiply(block.rgb, factor), 0.0, 1.0)))
            for block, factor in zip(blocks, factors, strict=True)
        )

    def measured(self, frame: Frame, rng: np.random.Generator) -> Frame:
        """The image with noise on its depth."""
        if self.depth_m == 0.0:
            return frame
        noise = rng.normal(0.0, self.depth_m, frame.depth.shape)
        return replace(frame, depth=(frame.depth + noise).astype(np.float32))


UNDISTURBED = Disturbance()


def _three(values: NDArray[np.float64]) -> Vector3:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
