"""The pinhole camera model, without distortion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from nsrm_harness.geometry.pose import Pose, Quaternion, Vector3

NEAR_M = 0.3
FAR_M = 4.0
"""Clipping planes of the renderers, along the optical axis."""

MIN_VISIBLE_PX = 40
"""A block with fewer visible pixels does not count as observed: no detector would report it."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in the world.

    * `width`, `height`: image size, pixels; the centre of pixel (i, j) is at (i + ½, j + ½)
    * `fx`, `fy`, `cx`, `cy`: focal lengths and principal point, pixels
    * `position`, `orientation`: `world_from_camera`, metres and quaternion x, y, z, w;
      the camera's frame has x to the right, y down, z forward
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    position: Vector3
    orientation: Quaternion

    @staticmethod
    def looking_at(
        position: Vector3, target: Vector3, *, width: int, height: int, focal_px: float
    ) -> Camera:
        """An upright camera with square pixels and the principal point in the middle.

        Raises `ValueError` if it would look straight up or down.
        """
        forward = np.subtract(target, position, dtype=np.float64)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        if np.linalg.norm(right) < 1e-6:
            raise ValueError("a camera that looks straight up or down has no upright direction")
        right /= np.linalg.norm(right)
        down = np.cross(forward, right)
        axes = Rotation.from_matrix(np.column_stack([right, down, forward]))
        x, y, z, w = map(float, axes.as_quat())
        return Camera(
            width, height, focal_px, focal_px, width / 2, height / 2, position, (x, y, z, w)
        )

    @property
    def pose(self) -> Pose:
        """`world_from_camera`."""
        return Pose(self.position, self.orientation)

    def to_camera(self, points: ArrayLike) -> NDArray[np.float64]:
        """World points `[..., 3]` in the camera's frame, metres."""
        return (np.asarray(points, dtype=np.float64) - self.position) @ self.pose.rotation()

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """World points `[..., 3]` to `[..., 3]`: column and row in pixels (not
        limited to the image), depth along the optical axis in metres."""
        x, y, z = np.moveaxis(self.to_camera(points), -1, 0)
        return np.stack([self.fx * x / z + self.cx, self.fy * y / z + self.cy, z], axis=-1)

    def back_project(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """The inverse of `project`: `[..., 3]` column, row, depth to world points."""
        u, v, z = np.moveaxis(np.asarray(pixels, dtype=np.float64), -1, 0)
        local = np.stack([(u - self.cx) / self.fx * z, (v - self.cy) / self.fy * z, z], axis=-1)
        return local @ self.pose.rotation().T + self.position

    def view_matrix(self) -> NDArray[np.float64]:
        """OpenGL's `[4, 4]` camera-from-world: x right, y up, z backward."""
        flip = np.diag([1.0, -1.0, -1.0])
        view = np.eye(4)
        view[:3, :3] = flip @ self.pose.rotation().T
        view[:3, 3] = -view[:3, :3] @ self.position
        return view

    def projection_matrix(self, shift_px: tuple[float, float] = (0.0, 0.0)) -> NDArray[np.float64]:
        """OpenGL's `[4, 4]` clip-from-camera between `NEAR_M` and `FAR_M`.

        `shift_px`: added to the principal point, for a renderer that does not
        sample at the pixels' centres.
        """
        cx, cy = self.cx + shift_px[0], self.cy + shift_px[1]
        near, far = NEAR_M, FAR_M
        return np.array(
            [
                [2 * self.fx / self.width, 0, 1 - 2 * cx / self.width, 0],
                [0, 2 * self.fy / self.height, 2 * cy / self.height - 1, 0],
                [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)],
                [0, 0, -1, 0],
            ]
        )

    def scaled(self, factor: int) -> Camera:
        """The same view with `factor` times as many pixels per side."""
        return Camera(
            self.width * factor,
            self.height * factor,
            self.fx * factor,
            self.fy * factor,
            self.cx * factor,
            self.cy * factor,
            self.position,
            self.orientation,
        )


def default_camera() -> Camera:
    """640×480, opposite the robot: image right is the world's +y.

    Sees every block in the workspace completely; a 4 cm block is 31 to 38 pixels wide.
    """
    return Camera.looking_at(
        (1.30, 0.0, 0.80), (0.33, 0.0, 0.0), width=640, height=480, focal_px=936.0
    )


def linear_depth(buffer: NDArray[np.float32]) -> NDArray[np.float32]:
    """Converts a depth buffer's values in 0..1 to metres along the optical axis."""
    depth = FAR_M * NEAR_M / (FAR_M - (FAR_M - NEAR_M) * buffer.astype(np.float64))
    return depth.astype(np.float32)
