"""Convex bodies and how far apart they are: the hulls of the arm's links, and boxes.

FCL and coal both compute each distance, and the smaller one counts: both report every overlap, but
FCL overestimates one distance in 200, because its iteration stops early.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any
from xml.etree import ElementTree

import fcl
import numpy as np
import trimesh
from numpy.typing import NDArray

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid

# Its types are made when it is loaded.
coal: Any = import_module("coal")

_FCL_REQUEST = fcl.DistanceRequest(enable_signed_distance=False)
_COAL_REQUEST = coal.DistanceRequest()


@dataclass(frozen=True, eq=False)
class _Shape:
    in_fcl: fcl.CollisionGeometry
    in_coal: Any
    centre: NDArray[np.float64]
    radius_m: float


class Body:
    """A convex body at a pose, as FCL and coal hold it.

    * `centre`: of its bounding sphere, in the body's frame, metres
    * `radius_m`: of its bounding sphere
    """

    def __init__(self, shape: _Shape) -> None:
        self._in_fcl = fcl.CollisionObject(shape.in_fcl, fcl.Transform())
        self._in_coal = coal.CollisionObject(shape.in_coal)
        self.centre, self.radius_m = shape.centre, shape.radius_m

    @classmethod
    def box(cls, cuboid: Cuboid) -> Body:
        """With the cuboid's edges, at its pose."""
        a, b, c = cuboid.edges_m
        radius_m = float(np.linalg.norm(cuboid.edges_m)) / 2
        body = cls(_Shape(fcl.Box(a, b, c), coal.Box(a, b, c), np.zeros(3), radius_m))
        body.move_to(cuboid.pose.rotation(), np.array(cuboid.pose.position))
        return body

    @classmethod
    def hull(cls, link: str) -> Body:
        """The convex hull of a link's collision mesh, with the link's frame at the origin."""
        return cls(_hulls()[link])

    def move_to(self, rotation: NDArray[np.float64], position: NDArray[np.float64]) -> None:
        """Moves the body's frame there; metres."""
        self._in_fcl.setTransform(fcl.Transform(rotation, position))
        self._in_coal.setTransform(coal.Transform3s(rotation, position))

    def distance_m(self, other: Body) -> float:
        """How far apart the two are; 0 if they touch or overlap."""
        fcl_m = fcl.distance(self._in_fcl, other._in_fcl, _FCL_REQUEST, fcl.DistanceResult())
        coal_m = coal.distance(self._in_coal, other._in_coal, _COAL_REQUEST, coal.DistanceResult())
        # Both return a negative distance for overlapping bodies.
        return max(0.0, min(float(fcl_m), float(coal_m)))


@lru_cache(maxsize=1)
def _hulls() -> dict[str, _Shape]:
    hulls = {}
    for link, mesh in link_convex_hulls().items():
        vertices = np.array(mesh.vertices)
        faces = np.insert(np.array(mesh.faces), 0, 3, axis=1).flatten()
        corners = coal.StdVec_Vec3s()
        corners.extend(list(vertices))
        centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        hulls[link] = _Shape(
            fcl.Convex(vertices, len(mesh.faces), faces),
            coal.Convex.convexHull(corners, True, ""),
            centre,
            float(np.linalg.norm(vertices - centre, axis=1).max()),
        )
    return hulls


@lru_cache(maxsize=1)
def link_convex_hulls() -> dict[str, trimesh.Trimesh]:
    """The convex hull of each link's collision mesh, in the link's frame."""
    meshes = {}
    for link in ElementTree.parse(panda.URDF).getroot().iter("link"):
        shape = link.find("collision/geometry/mesh")
        if shape is None:
            continue
        path = panda.URDF.parent / shape.attrib["filename"].removeprefix("package://")
        mesh = trimesh.load_mesh(path).convex_hull
        if link.find("collision/origin") is not None:
            # The right finger is the left one, rotated by half a turn about z.
            mesh.apply_transform(np.diag([-1.0, -1.0, 1.0, 1.0]))
        meshes[link.attrib["name"]] = mesh
    return meshes
