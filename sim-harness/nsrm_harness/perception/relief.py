"""Converts a depth image to heights above the table.

The camera's pose is known and the table is near the world's plane z = 0. The plane itself is fitted
to the image, so an error of millimetres in the pose does no harm.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.camera import Camera

#: Largest distance of a measured table point from the world's z = 0, metres.
TABLE_SEARCH_M = 0.02
#: Smallest share of pixels that must show the table.
MIN_TABLE_SHARE = 0.05
#: Noise (standard deviation, metres) above which depth is smoothed.
SMOOTHED_FROM_M = 0.00015

_STRIDE = 8
_FIT_ROUNDS = 3


class PerceptionError(HarnessError):
    """Input in which no objects can be found: an invalid image, no table, or too many objects."""


@dataclass(frozen=True, eq=False)
class Relief:
    """Heights above the table, as seen from above.

    * `x`, `y`: `float32 [H, W]`, world, metres
    * `height`: `float32 [H, W]`, above the fitted table, metres; NaN without depth
    * `depth`: `float32 [H, W]`, metres along the optical axis, holes filled
    * `measured`: `float32 [H, W]`, depth as measured, 0 where it was not
    * `noise_m`: standard deviation of `height` on the table
    * `noisy`: whether depth was smoothed, which makes edges rough
    """

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    height: NDArray[np.float32]
    depth: NDArray[np.float32]
    measured: NDArray[np.float32]
    noise_m: float
    noisy: bool


def relief(image: NDArray[np.uint8], depth: NDArray[np.float32], camera: Camera) -> Relief:
    """Computes the heights of a depth image.

    * `image`: `uint8 [H, W, 3]`; where depth was not measured, its colours decide which neighbour
      replaces it
    * `depth`: `float32 [H, W]`, metres along the optical axis; values that are not finite, or not
      above 0, are missing
    * `camera`: the camera that took them, in the world whose z = 0 is near the table

    Raises `PerceptionError` for arrays of other shapes or types, and if less than
    `MIN_TABLE_SHARE` of the image is table.
    """
    _check(image, depth, camera)
    measured = measurements(depth)
    filled = _filled(image, measured)
    noisy = _depth_noise_m(measured) > SMOOTHED_FROM_M
    if noisy:
        filled = cv2.medianBlur(filled, 5).astype(np.float32, copy=False)
    rays = _rays(camera)
    px, py, pz = camera.position
    x, y, z = rays[0] * filled + px, rays[1] * filled + py, rays[2] * filled + pz
    a, b, c, residual_m = _table(x, y, z)
    height = z - (a + b * x + c * y)
    height[filled <= 0] = np.nan
    return Relief(x, y, height, filled, measured, residual_m, noisy)


def measurements(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth with 0 in place of all missing measurements."""
    return np.where(np.isfinite(depth) & (depth > 0), depth, np.float32(0.0))


def _check(image: NDArray[np.uint8], depth: NDArray[np.float32], camera: Camera) -> None:
    for name, array, shape, kind in (
        ("image", image, (camera.height, camera.width, 3), np.uint8),
        ("depth", depth, (camera.height, camera.width), np.float32),
    ):
        if array.shape != shape or array.dtype != kind:
            raise PerceptionError(
                f"{name}: expected {np.dtype(kind).name} {list(shape)}, as for the camera, "
                f"got {array.dtype.name} {list(array.shape)}"
            )


@lru_cache(maxsize=4)
def _rays(camera: Camera) -> NDArray[np.float32]:
    """World directions `[3, H, W]` of the pixel centres, with length 1 along the optical axis."""
    columns = (np.arange(camera.width) + 0.5 - camera.cx) / camera.fx
    rows = (np.arange(camera.height) + 0.5 - camera.cy) / camera.fy
    rotation = camera.pose.rotation()
    rays = (
        rotation[:, 0, None, None] * columns[None, None, :]
        + rotation[:, 1, None, None] * rows[None, :, None]
        + rotation[:, 2, None, None]
    )
    return np.ascontiguousarray(rays, dtype=np.float32)


def _depth_noise_m(depth: NDArray[np.float32]) -> float:
    """Standard deviation of white noise in `measurements`, from second differences, which almost
    vanish on planes."""
    rows = depth[::_STRIDE]
    left, middle, right = rows[:, :-2], rows[:, 1:-1], rows[:, 2:]
    second = left - 2 * middle + right
    known = np.minimum(np.minimum(left, middle), right) > 0
    if not known.any():
        return 0.0
    return float(1.4826 * np.median(np.abs(second[known])) / np.sqrt(6.0))


def _filled(image: NDArray[np.uint8], measured: NDArray[np.float32]) -> NDArray[np.float32]:
    """Fills each missing measurement with the depth of the neighbour, of eight, with the most
    similar colour; 0 if there is none."""
    rows, columns = np.nonzero(measured == 0)
    if len(rows) == 0:
        return measured
    known = cv2.copyMakeBorder(measured, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    colors = cv2.copyMakeBorder(image, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    own = image[rows, columns].astype(np.int32)
    best = np.full(len(rows), np.iinfo(np.int32).max)
    values = np.zeros(len(rows), dtype=np.float32)
    for down in (0, 1, 2):
        for right in (0, 1, 2):
            value = known[rows + down, columns + right]
            apart = np.abs(colors[rows + down, columns + right] - own).sum(axis=1)
            nearer = (value > 0) & (apart < best)
            best[nearer], values[nearer] = apart[nearer], value[nearer]
    filled = np.array(known[1:-1, 1:-1], dtype=np.float32)
    filled[rows, columns] = values
    return filled


def _table(
    x: NDArray[np.float32], y: NDArray[np.float32], z: NDArray[np.float32]
) -> tuple[np.float32, np.float32, np.float32, float]:
    """Fits the table z = a + b·x + c·y by least squares on inliers; returns a, b, c and the
    standard deviation of the inliers' heights."""
    xs, ys, zs = (part[::_STRIDE, ::_STRIDE].ravel().astype(np.float64) for part in (x, y, z))
    near = np.abs(zs) < TABLE_SEARCH_M
    if np.count_nonzero(near) < MIN_TABLE_SHARE * near.size:
        raise PerceptionError(
            f"no table in view: {np.count_nonzero(near)} of {near.size} sampled pixels lie within "
            f"{TABLE_SEARCH_M} m of the world's z = 0: check depth (metres along the optical "
            f"axis) and the camera's pose"
        )
    terms = np.stack([np.ones_like(xs), xs, ys], axis=1)
    plane = np.array([np.median(zs[near]), 0.0, 0.0])
    spread = TABLE_SEARCH_M
    for _ in range(_FIT_ROUNDS):
        heights = zs - terms @ plane
        near = np.abs(heights) < max(3 * spread, 0.0005)
        plane = np.linalg.lstsq(terms[near], zs[near], rcond=None)[0]
        heights = zs[near] - terms[near] @ plane
        spread = 1.4826 * float(np.median(np.abs(heights)))
    a, b, c = plane.astype(np.float32)
    return a, b, c, spread
