"""The scene for both renderers: table, floor, robot, blocks and their shadows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import NEAR_M, Camera
from nsrm_harness.geometry.mesh import Mesh, box, level_polygons
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.simulation import arm
from nsrm_harness.simulation.render.light import Light
from nsrm_harness.simulation.world import TABLE_HIGH, TABLE_LOW, PlacedBlock

TABLE_RGB: Vector3 = (0.66, 0.63, 0.58)
FLOOR_RGB: Vector3 = (0.40, 0.42, 0.45)
FLOOR_Z_M = -0.75

SHADOW_LAYERS = 5
SHADOW_DEPTH = 0.72
"""Share of the lamp's light that the darkest layer blocks."""
LAMP_RADIUS = 0.10
"""Half of the lamp's angular size, radians: shadows get softer with height."""
SHADOW_RIM_M = 0.0015
"""Width of the soft edge at the ground."""
LAYER_STEP_M = 0.00005
"""Distance between the layers of a shadow on the table."""


@dataclass(frozen=True, eq=False)
class RenderPart:
    """A mesh with its pose."""

    mesh: Mesh
    pose: Pose


_ORIGIN = Pose((0.0, 0.0, 0.0))
_CORNER_SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


@lru_cache(maxsize=1)
def surroundings() -> tuple[RenderPart, ...]:
    """Table and floor, the closer one first."""
    (x0, y0, _), (x1, y1, _) = TABLE_LOW, TABLE_HIGH
    floor = [(-6.0, -6.0), (3.0, -6.0), (3.0, 6.0), (-6.0, 6.0)]
    floor_mesh = level_polygons([floor], FLOOR_Z_M, FLOOR_RGB)
    table = box((x0, y0, TABLE_LOW[2]), (x1, y1, 0.0), TABLE_RGB)
    return (RenderPart(table, _ORIGIN), RenderPart(floor_mesh, _ORIGIN))


def robot_parts(links: dict[str, Pose], camera: Camera) -> Iterator[RenderPart]:
    """The meshes of the links that may be in the camera's view."""
    for visual in arm.link_visuals():
        if visual.link in links:
            pose = links[visual.link]
            center = pose.rotation() @ visual.center + np.array(pose.position)
            if _in_view(center, visual.radius_m, camera):
                for mesh in visual.meshes:
                    yield RenderPart(mesh, pose)


def _in_view(center: NDArray[np.float64], radius: float, camera: Camera) -> bool:
    """Whether a sphere intersects the camera's view frustum."""
    x, y, z = camera.to_camera(center)
    if z < NEAR_M - radius:
        return False
    for offset, focal, low, high in (
        (x, camera.fx, -camera.cx, camera.width - camera.cx),
        (y, camera.fy, -camera.cy, camera.height - camera.cy),
    ):
        # Signed distances to two sides of the frustum, through the optical centre.
        if (offset * focal - low * z) / np.hypot(focal, low) < -radius:
            return False
        if (high * z - offset * focal) / np.hypot(focal, high) < -radius:
            return False
    return True


def shadow_parts(blocks: Sequence[PlacedBlock], light: Light) -> Iterator[RenderPart]:
    """The blocks' shadows on the table, as flat layers; larger layers are lighter.

    Each layer is the outline that a smaller or larger lamp would cast. With its colour, the light
    model shows the table with a part of the lamp hidden.
    """
    if not blocks or light.direction[2] <= 0.05:
        return
    full = np.array(light.shade((0.0, 0.0, 1.0)))
    ground, away, widths = _cast(blocks, light)
    for layer in range(SHADOW_LAYERS):
        spread = 1.0 - 2.0 * layer / (SHADOW_LAYERS - 1)
        hidden = SHADOW_DEPTH * (layer + 1) / SHADOW_LAYERS
        kept = light.ambient + (1.0 - hidden) * (full - light.ambient)
        red, green, blue = (float(v) for v in np.array(TABLE_RGB) * kept / full)
        outlines = [_convex_hull(points) for points in (ground + away * spread * widths).tolist()]
        height = (layer + 1) * LAYER_STEP_M
        yield RenderPart(level_polygons(outlines, height, (red, green, blue)), _ORIGIN)


def _cast(
    blocks: Sequence[PlacedBlock], light: Light
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The shadows `[B, 8, 2]` of the blocks' corners on the table, the directions
    `[B, 8, 2]` away from the blocks' axes and the widths of the penumbras `[B, 8, 1]`, metres."""
    half = np.array([placed.block.edges_m for placed in blocks]) / 2
    rotation = np.array([placed.pose.rotation() for placed in blocks])
    center = np.array([placed.pose.position for placed in blocks])[:, None]
    corners = (_CORNER_SIGNS * half[:, None]) @ rotation.swapaxes(1, 2) + center
    heights = np.maximum(corners[..., 2:], 0.0)
    slope = np.array(light.direction[:2]) / light.direction[2]
    ground = corners[..., :2] - heights * slope
    # Away from the block's own axis at that height, by the lamp's apparent size.
    away = ground - (center[..., :2] - heights * slope)
    away /= np.linalg.norm(away, axis=-1, keepdims=True)
    return ground, away, SHADOW_RIM_M + LAMP_RADIUS * heights


def _convex_hull(points: list[list[float]]) -> list[list[float]]:
    """Andrew's monotone chain: corners x, y, counter-clockwise."""
    ordered = sorted(points)

    def chain(sequence: list[list[float]]) -> list[list[float]]:
        kept: list[list[float]] = []
        for point in sequence:
            while len(kept) >= 2 and _turn(kept[-2], kept[-1], point) <= 1e-12:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    return chain(ordered) + chain(ordered[::-1])


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    """Twice the triangle's area, positive if a, b, c turn to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
