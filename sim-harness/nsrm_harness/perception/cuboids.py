"""Estimates the blocks in an image as cuboids, which an arm grasps, places and avoids."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.perception.detector import Detections
from nsrm_harness.perception.relief import Relief

TOP_M = 0.0055
"""Points within this height below a block's highest one, studs included, belong to its top."""
FLAT_M = 0.01
"""Every block is higher than this."""
EDGE_M = 0.003
"""Largest difference between two observations of one top face, in the lengths of its edges,"""
HEIGHT_M = 0.002
"""and in height: studs are higher than this."""
FACE_M = 0.004
"""The visible part of a cuboid may lie outside it by this much:"""
WITHIN_SHARE = 0.95
"""at least this share of its points must lie within that distance."""
HIDDEN_SHARE = 0.8
"""At least this share of an assumed hidden part must be hidden."""
NEARER_M = 0.005
"""An object covers a point if it is closer to the camera by more than this."""
SAMPLES = 13
"""Number of points along each edge of a top face at which this is checked."""
BEHIND_M = 0.02
"""If the surface seen at a point is this far behind it, nothing is at the point."""


@dataclass(frozen=True, eq=False)
class Face:
    """The visible part of an object in one image.

    * `points`: `float32 [n, 3]`, its visible points, world frame, metres
    * `cuboid`: the visible part of its top face, extended down to the table
    """

    points: NDArray[np.float32]
    cuboid: Cuboid


def faces(found: Detections, seen: Relief, camera: Camera) -> list[Face]:
    """The top face of each detection."""
    seen_faces = []
    for row in range(len(found)):
        own = found.labels == row + 1
        points = np.stack([seen.x[own], seen.y[own], seen.height[own]], axis=1)
        # NaN where nothing was measured.
        points = points[np.isfinite(points[:, 2])]
        seen_faces.append(Face(points, _from_top(points, camera)))
    return seen_faces


class Cuboids:
    """Tracks the objects as cuboids across images and completes hidden parts from earlier ones.

    An object is assumed to be where it was last seen whole as long as its visible part lies there;
    if nothing of it is visible, as long as nothing is seen behind it. An object that was moved to
    where others cover a part of it keeps its edges and is assumed to continue behind them.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._known: dict[int, Cuboid] = {}

    def update(self, objects: Mapping[int, Face], seen: Relief) -> dict[int, Cuboid]:
        """Updates the cuboids with an image; returns all objects that are assumed to exist, by
        number.

        * `objects`: the visible objects by number, as a `Tracker` numbers them
        """
        tops = {}
        for number, face in objects.items():
            now, before = face.cuboid, self._known.get(number)
            if before is not None and not _is_whole(now, before):
                is_there = _within(face.points, before)
                now = before if is_there else self._completed(now, before, seen)
            tops[number] = now
        for number, before in self._known.items():
            if number not in tops and not self._is_seen_through(before, seen):
                tops[number] = before
        self._known = {
            number: _standing(cuboid, [*tops.values()], self._known.get(number))
            for number, cuboid in tops.items()
        }
        return dict(self._known)

    def forget(self, numbers: Iterable[int]) -> None:
        """Forgets these objects."""
        for number in numbers:
            self._known.pop(number, None)

    def _completed(self, now: Cuboid, before: Cuboid, seen: Relief) -> Cuboid:
        """Completes the visible part of a block's top face to the edges that it had. The rest must
        lie where something closer to the camera is seen; otherwise the visible part is returned."""
        length, width, height = before.edges_m
        if now.edges_m[2] < height - HEIGHT_M:
            return now
        best, most = now, HIDDEN_SHARE
        for edges in ((length, width), (width, length)):
            missing = np.subtract(edges, now.edges_m[:2])
            if (missing < -EDGE_M).any():
                continue
            missing = np.maximum(missing, 0.0)
            for side in itertools.product((-0.5, 0.5), repeat=2):
                shift = now.pose.rotation()[:2, :2] @ (missing * side)
                x, y, z = now.pose.position
                pose = replace(now.pose, position=(x + float(shift[0]), y + float(shift[1]), z))
                whole = Cuboid(pose, (*edges, now.edges_m[2]))
                hidden = self._hidden_share(whole, now, seen)
                if hidden > most:
                    best, most = whole, hidden
        return best

    def _hidden_share(self, whole: Cuboid, visible: Cuboid, seen: Relief) -> float:
        """The share of a top face, without its visible part, that is behind something closer to the
        camera."""
        steps = np.linspace(-0.5, 0.5, SAMPLES)
        local = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        flat = (local * whole.edges_m[:2]) @ whole.pose.rotation()[:2, :2].T
        flat += whole.pose.position[:2]
        own = (flat - visible.pose.position[:2]) @ visible.pose.rotation()[:2, :2]
        beyond = flat[(np.abs(own) > np.array(visible.edges_m[:2]) / 2 + EDGE_M).any(axis=1)]
        if not len(beyond):
            return 0.0
        points = np.column_stack([beyond, np.full(len(beyond), whole.top_m)])
        return float((self._nearer_m(points, seen) > NEARER_M).mean())

    def _is_seen_through(self, cuboid: Cuboid, seen: Relief) -> bool:
        """Whether the background is seen behind all corners of its top face."""
        corners = np.column_stack([cuboid.corners(), np.full(4, cuboid.top_m)])
        return bool((self._nearer_m(corners, seen) < -BEHIND_M).all())

    def _nearer_m(self, points: NDArray[np.float64], seen: Relief) -> NDArray[np.float64]:
        """How much closer to the camera than the points `[n, 3]` the surface seen there is, along
        the optical axis."""
        pixels = self._camera.project(points)
        columns, rows = np.floor(pixels[:, :2]).astype(int).T
        columns = np.clip(columns, 0, self._camera.width - 1)
        rows = np.clip(rows, 0, self._camera.height - 1)
        return np.asarray(pixels[:, 2] - seen.depth[rows, columns], np.float64)


def _from_top(points: NDArray[np.float32], camera: Camera) -> Cuboid:
    """The smallest rectangle, seen from above, around the points `[n, 3]` of the top face, extended
    down to the table."""
    top = float(points[:, 2].max())
    face = points[points[:, 2] > top - TOP_M][:, :2]
    (x, y), edges, yaw = _rectangle(np.concatenate([face, _far_sides(face, top, camera)]))
    return Cuboid(Pose.upright(x, y, top / 2, yaw), (*edges, top))


def _far_sides(face: NDArray[np.float32], height_m: float, camera: Camera) -> NDArray[np.float32]:
    """The far ends of the pixels of a level face that is seen obliquely from above: half a pixel
    farther from the camera than their centres. At its near side, the face below continues."""
    away = face - np.array(camera.position[:2], np.float32)
    along_m = np.linalg.norm(away, axis=1, keepdims=True)
    above_m = camera.position[2] - height_m
    half_m = (along_m**2 + above_m**2) / above_m / camera.fy / 2
    return (face + away / along_m * half_m).astype(np.float32)


def _is_whole(now: Cuboid, before: Cuboid) -> bool:
    """Whether a block's top face, with its studs, is completely visible again."""
    edges = zip(sorted(now.edges_m[:2]), sorted(before.edges_m[:2]), strict=True)
    has_same_plan = all(abs(a - b) <= EDGE_M for a, b in edges)
    return has_same_plan and now.top_m > before.top_m - HEIGHT_M


def _within(points: NDArray[np.float32], cuboid: Cuboid) -> bool:
    """Whether nearly all points lie inside a cuboid or on its faces."""
    local = (points - np.array(cuboid.pose.position)) @ cuboid.pose.rotation()
    inside = (np.abs(local) <= np.array(cuboid.edges_m) / 2 + FACE_M).all(axis=1)
    return float(inside.mean()) >= WITHIN_SHARE


def _standing(cuboid: Cuboid, others: Sequence[Cuboid], before: Cuboid | None) -> Cuboid:
    """The cuboid extended down not to the table, but to the highest other one below its middle; or
    below any part of it, if it then has the height that it had before, since little may be visible
    of a block that supports another one."""
    x, y, _ = cuboid.pose.position
    plan = Polygon(cuboid.corners())

    def bears(other: Cuboid) -> bool:
        if before is None or abs(cuboid.top_m - before.edges_m[2] - other.top_m) > TOP_M:
            return False
        return bool(plan.intersects(Polygon(other.corners())))

    under = [
        other.top_m
        for other in others
        if other.top_m < cuboid.top_m - FLAT_M and (_is_above(other, x, y) or bears(other))
    ]
    foot, top = max(under, default=0.0), cuboid.top_m
    pose = replace(cuboid.pose, position=(x, y, (foot + top) / 2))
    return Cuboid(pose, (*cuboid.edges_m[:2], top - foot))


def _is_above(cuboid: Cuboid, x: float, y: float) -> bool:
    """Whether a point lies inside a cuboid seen from above."""
    local = cuboid.pose.rotation()[:2, :2].T @ np.subtract((x, y), cuboid.pose.position[:2])
    return bool((np.abs(local) <= np.array(cuboid.edges_m[:2]) / 2).all())


def _rectangle(
    points: NDArray[np.float32],
) -> tuple[tuple[float, float], tuple[float, float], float]:
    """The smallest rectangle around points `[n, 2]`: centre, edges, and the angle of its first edge
    to x, less than an eighth of a turn."""
    # In millimetres: OpenCV treats lengths below 1e-4 as zero.
    (x, y), (a, b), angle = cv2.minAreaRect(points * np.float32(1000.0))
    # The quadrant of its angle depends on the version and on the order of the points.
    quarters = round(angle / 90.0)
    if quarters % 2:
        a, b = b, a
    return (x / 1000, y / 1000), (a / 1000, b / 1000), math.radians(angle - 90.0 * quarters)
