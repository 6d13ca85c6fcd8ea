"""Triangle meshes for both renderers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.pose import Vector3

STUD_SIDES = 16
"""Number of sides of the prism that represents a stud."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one colour, in the frame of the body they belong to.

    * `vertices`: `[V, 3]` metres
    * `normals`: `[V, 3]` unit vectors, outward
    * `triangles`: `[T, 3]` indices of vertices, counter-clockwise from outside
    * `rgb`: colour in full light, each in 0..1
    """

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    triangles: NDArray[np.int32]
    rgb: Vector3

    def bounds_m(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """The minimum and maximum corner."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)


class _Builder:
    """Collects convex, flat polygons, each with its own vertices and one normal."""

    def __init__(self) -> None:
        self._vertices: list[NDArray[np.float64]] = []
        self._normals: list[NDArray[np.float64]] = []
        self._triangles: list[NDArray[np.int32]] = []
        self._count = 0

    def polygon(self, corners: Sequence[Sequence[float]] | NDArray[np.float64]) -> None:
        points = np.asarray(corners, dtype=np.float64)
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        normal /= np.linalg.norm(normal)
        fan = [[0, i, i + 1] for i in range(1, len(points) - 1)]
        self._vertices.append(points)
        self._normals.append(np.tile(normal, (len(points), 1)))
        self._triangles.append(np.array(fan, dtype=np.int32) + self._count)
        self._count += len(points)

    def build(self, rgb: Vector3) -> Mesh:
        return Mesh(
            np.concatenate(self._vertices).astype(np.float32),
            np.concatenate(self._normals).astype(np.float32),
            np.concatenate(self._triangles),
            rgb,
        )


def level_polygons(
    outlines: Sequence[Sequence[Sequence[float]]], height_m: float, rgb: Vector3
) -> Mesh:
    """Convex polygons with corners x, y, counter-clockwise, all at one height, facing up."""
    corners = [(x, y, height_m) for outline in outlines for x, y in outline]
    triangles: list[tuple[int, int, int]] = []
    first = 0
    for outline in outlines:
        triangles += [(first, first + i, first + i + 1) for i in range(1, len(outline) - 1)]
        first += len(outline)
    return Mesh(
        np.array(corners, dtype=np.float32),
        np.tile(np.array((0.0, 0.0, 1.0), dtype=np.float32), (len(corners), 1)),
        np.array(triangles, dtype=np.int32),
        rgb,
    )


def _add_box(builder: _Builder, low: Vector3, high: Vector3) -> None:
    (x0, y0, z0), (x1, y1, z1) = low, high
    builder.polygon([(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)])
    builder.polygon([(x0, y1, z0), (x1, y1, z0), (x1, y0, z0), (x0, y0, z0)])
    builder.polygon([(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)])
    builder.polygon([(x0, y1, z0), (x0, y0, z0), (x0, y0, z1), (x0, y1, z1)])
    builder.polygon([(x1, y1, z0), (x0, y1, z0), (x0, y1, z1), (x1, y1, z1)])
    builder.polygon([(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)])


def box(low: Vector3, high: Vector3, rgb: Vector3) -> Mesh:
    """An upright box between two corners, with flat normals."""
    builder = _Builder()
    _add_box(builder, low, high)
    return builder.build(rgb)


def studded_box(
    edges_m: Vector3,
    studs: tuple[int, int] | None,
    stud_height_m: float,
    rgb: Vector3,
) -> Mesh:
    """A block about its own centre: `edges_m` includes the studs.

    `studs`: rows along x, columns along y, or none. Their diameter is 0.6 of the
    spacing, that of the toy.
    """
    hx, hy, hz = (edge / 2 for edge in edges_m)
    builder = _Builder()
    if studs is None:
        _add_box(builder, (-hx, -hy, -hz), (hx, hy, hz))
        return builder.build(rgb)
    shoulder = hz - stud_height_m
    _add_box(builder, (-hx, -hy, -hz), (hx, hy, shoulder))
    rows, columns = studs
    pitch_x, pitch_y = edges_m[0] / rows, edges_m[1] / columns
    radius = 0.3 * min(pitch_x, pitch_y)
    angles = 2 * np.pi * np.arange(STUD_SIDES) / STUD_SIDES
    circle = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for row in range(rows):
        for column in range(columns):
            centre = (-hx + (row + 0.5) * pitch_x, -hy + (column + 0.5) * pitch_y)
            ring = circle + np.array(centre)
            low = np.column_stack([ring, np.full(STUD_SIDES, shoulder)])
            high = np.column_stack([ring, np.full(STUD_SIDES, hz)])
            builder.polygon(high)
            for i in range(STUD_SIDES):
                j = (i + 1) % STUD_SIDES
                builder.polygon(np.stack([low[i], low[j], high[j], high[i]]))
    return builder.build(rgb)


def load_obj(path: Path) -> list[Mesh]:
    """The meshes of a Wavefront OBJ file, one per material colour.

    Reads triangles with normals (`f v/t/n` or `f v//n`) and the diffuse colour of
    the `.mtl` next to it; textures are ignored. Raises `ValueError` for any other kind of
    face.
    """
    vertices: list[str] = []
    normals: list[str] = []
    faces: dict[str, list[str]] = {}
    colors: dict[str, Vector3] = {}
    current = faces.setdefault("", [])
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        kind, _, rest = line.partition(" ")
        if kind == "v":
            vertices.append(rest)
        elif kind == "vn":
            normals.append(rest)
        elif kind == "f":
            current.append(rest)
        elif kind == "usemtl":
            current = faces.setdefault(rest.strip(), [])
        elif kind == "mtllib":
            colors.update(_material_colors(path.parent / rest.strip()))
    positions = _table(path, vertices)
    directions = _table(path, normals)
    by_color: dict[Vector3, list[str]] = {}
    for material, lines in faces.items():
        by_color.setdefault(colors.get(material, (1.0, 1.0, 1.0)), []).extend(lines)
    meshes = []
    for rgb, lines in sorted(by_color.items()):
        if lines:
            meshes.append(_indexed(path, positions, directions, lines, rgb))
    return meshes


def _table(path: Path, lines: list[str]) -> NDArray[np.float32]:
    values = np.fromstring(" ".join(lines), dtype=np.float32, sep=" ")
    if not lines or values.size != 3 * len(lines):
        raise ValueError(f"{path}: vertices and normals must have three numbers each")
    return values.reshape(-1, 3)


def _indexed(
    path: Path,
    positions: NDArray[np.float32],
    directions: NDArray[np.float32],
    lines: list[str],
    rgb: Vector3,
) -> Mesh:
    # Three numbers per corner: vertex, texture (0 for none), normal.
    text = " ".join(lines).replace("//", "/0/").replace("/", " ")
    numbers = np.fromstring(text, dtype=np.int64, sep=" ")
    if numbers.size != 9 * len(lines):
        raise ValueError(f"{path}: every face must be a triangle whose corners name a normal")
    corners = numbers.reshape(-1, 3) - 1
    keys = corners[:, 0] * len(directions) + corners[:, 2]
    unique, inverse = np.unique(keys, return_inverse=True)
    return Mesh(
        positions[unique // len(directions)],
        directions[unique % len(directions)],
        inverse.reshape(-1, 3).astype(np.int32),
        rgb,
    )


def _material_colors(path: Path) -> dict[str, Vector3]:
    if not path.is_file():
        return {}
    colors: dict[str, Vector3] = {}
    name = ""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        kind, _, rest = line.strip().partition(" ")
        if kind == "newmtl":
            name = rest.strip()
        elif kind == "Kd":
            red, green, blue = (float(value) for value in rest.split()[:3])
            colors[name] = (red, green, blue)
    return colors
