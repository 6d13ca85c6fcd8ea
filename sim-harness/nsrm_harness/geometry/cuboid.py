"""Cuboids: the objects that an arm grasps, places and avoids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.pose import Pose, Vector3


@dataclass(frozen=True)
class Cuboid:
    """A box in space.

    * `pose`: pose of its centre
    * `edges_m`: edge lengths along its own x, y, z
    """

    pose: Pose
    edges_m: Vector3

    @property
    def top_m(self) -> float:
        """Height of the top face of an upright cuboid, metres."""
        return self.pose.position[2] + self.edges_m[2] / 2

    @property
    def bottom_m(self) -> float:
        """Height of the bottom face."""
        return self.pose.position[2] - self.edges_m[2] / 2

    def corners(self) -> NDArray[np.float64]:
        """Corners of an upright cuboid seen from above, `[4, 2]`, counter-clockwise."""
        half = np.array(self.edges_m[:2]) / 2
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
        return corners @ self.pose.rotation()[:2, :2].T + self.pose.position[:2]
