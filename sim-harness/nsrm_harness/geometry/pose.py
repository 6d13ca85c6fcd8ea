"""Poses: position and orientation in the world frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Pose:
    """A frame in the world: `world_from_body`.

    * `position`: metres, x forward, y left, z up, robot base at the origin
    * `orientation`: unit quaternion, x, y, z, w
    """

    position: Vector3
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    @staticmethod
    def upright(x: float, y: float, z: float, yaw_rad: float = 0.0) -> Pose:
        """The pose of an upright body, rotated by `yaw_rad` about the vertical."""
        return Pose((x, y, z), (0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)))

    def rotation(self) -> NDArray[np.float64]:
        """The rotation matrix `[3, 3]`: its columns are the body's axes in the world."""
        x, y, z, w = self.orientation
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        )

    def matrix(self) -> NDArray[np.float64]:
        """The homogeneous transform `[4, 4]` from body to world."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation()
        matrix[:3, 3] = self.position
        return matrix

    def __matmul__(self, other: Pose) -> Pose:
        """Composes two poses: `other`, given in the body's frame, in the world frame."""
        x, y, z, w = self.orientation
        i, j, k, r = other.orientation
        offset = self.rotation() @ other.position
        px, py, pz = (float(a + b) for a, b in zip(self.position, offset, strict=True))
        return Pose(
            (px, py, pz),
            (
                w * i + x * r + y * k - z * j,
                w * j - x * k + y * r + z * i,
                w * k + x * j - y * i + z * r,
                w * r - x * i - y * j - z * k,
            ),
        )

    def inverse(self) -> Pose:
        """The inverse: the world in the body's frame."""
        x, y, z, w = self.orientation
        turned = Pose((0.0, 0.0, 0.0), (-x, -y, -z, w))
        px, py, pz = (float(-value) for value in turned.rotation() @ self.position)
        return Pose((px, py, pz), turned.orientation)

    def yaw_rad(self) -> float:
        """The rotation about the vertical, in (-pi, pi]."""
        x, y, z, w = self.orientation
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))

    def distance_m(self, other: Pose) -> float:
        """Distance between the two origins."""
        return math.dist(self.position, other.position)

    def angle_rad(self, other: Pose) -> float:
        """The smallest angle between the two orientations, in [0, pi]."""
        a, b = np.array(self.orientation), np.array(other.orientation)
        apart, across = float(np.linalg.norm(a - b)), float(np.linalg.norm(a + b))
        # |a - b| = 2 sin(angle / 4): exact for small angles, where acos(a · b) is not.
        return 4 * math.atan2(min(apart, across), max(apart, across))
