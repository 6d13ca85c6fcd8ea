"""Computes the view of the empty table and floor.

TinyRenderer spends most of its time on triangles that fill the image. So behind the bodies that it
draws, each pixel's ray is intersected with the table's slab and the floor instead; the result
equals that of the meshes in `scene.surroundings`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import FAR_M, Camera
from nsrm_harness.geometry.pose import Vector3
from nsrm_harness.simulation.render.light import Light
from nsrm_harness.simulation.render.scene import FLOOR_RGB, FLOOR_Z_M, TABLE_RGB
from nsrm_harness.simulation.world import TABLE_HIGH, TABLE_LOW

_UP: Vector3 = (0.0, 0.0, 1.0)

_SURFACES: tuple[tuple[Vector3, Vector3], ...] = (
    ((0.0, 0.0, 0.0), _UP),
    (FLOOR_RGB, _UP),
    (TABLE_RGB, (-1.0, 0.0, 0.0)),
    (TABLE_RGB, (1.0, 0.0, 0.0)),
    (TABLE_RGB, (0.0, -1.0, 0.0)),
    (TABLE_RGB, (0.0, 1.0, 0.0)),
    (TABLE_RGB, (0.0, 0.0, -1.0)),
    (TABLE_RGB, _UP),
)
"""Colour and normal: nothing, floor, the table's faces (low and high along x, y, z)."""
_NOTHING, _FLOOR, _TABLE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Backdrop:
    """One camera's view of the empty table.

    * `surface`: `uint8 [H, W]`, the surface at each pixel's centre, an index of `_SURFACES`
    * `depth`: `float32 [H, W]`, metres along the optical axis, `FAR_M` for nothing
    """

    surface: NDArray[np.uint8]
    depth: NDArray[np.float32]

    def rgb(self, light: Light) -> NDArray[np.uint8]:
        """The image `[H, W, 3]` in this light."""
        palette = [np.multiply(color, light.shade(normal)) for color, normal in _SURFACES]
        shades = np.clip(np.rint(255 * np.array(palette)), 0, 255).astype(np.uint8)
        return shades[self.surface]


@lru_cache(maxsize=8)
def backdrop(camera: Camera) -> Backdrop:
    """The backdrop of a camera, computed once per camera."""
    columns, rows = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    local = np.stack(
        [
            (columns - camera.cx) / camera.fx,
            (rows - camera.cy) / camera.fy,
            np.ones_like(columns),
        ],
        axis=-1,
    )
    # The third component in the camera's frame is 1: distances along these rays are
    # depths along the optical axis.
    rays = local @ camera.pose.rotation().T
    origin = np.array(camera.position)
    with np.errstate(divide="ignore"):
        to_floor = (FLOOR_Z_M - origin[2]) / rays[..., 2]
        low, high = ((np.array(c) - origin) / rays for c in (TABLE_LOW, TABLE_HIGH))
    entry, leave = np.minimum(low, high), np.maximum(low, high)
    axis = np.argmax(entry, axis=-1)
    to_table = np.take_along_axis(entry, axis[..., None], axis=-1)[..., 0]
    hits_table = (to_table > 0) & (to_table <= leave.min(axis=-1))
    face = 2 * axis + (np.take_along_axis(rays, axis[..., None], axis=-1)[..., 0] < 0)

    surface = np.where((to_floor > 0) & (to_floor < FAR_M), _FLOOR, _NOTHING)
    depth = np.where(surface == _FLOOR, to_floor, FAR_M)
    nearer = hits_table & (to_table < depth)
    return Backdrop(
        np.where(nearer, _TABLE + face, surface).astype(np.uint8),
        np.where(nearer, to_table, depth).astype(np.float32),
    )
