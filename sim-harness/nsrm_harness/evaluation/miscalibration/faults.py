"""Faults in a camera's calibration, units and conventions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.pose import Pose, Vector3

PERCENT = 0.01
MILLIMETRES = 1000.0

Change = Callable[[Camera], Camera]


@dataclass(frozen=True)
class Fault:
    """A fault in the reported camera.

    * `change`: gives the reported camera for the true one
    * `depth_scale`: factor on depths
    * `cause`: the expected `nsrm.Refused.details["cause"]`
    """

    name: str
    change: Change = lambda camera: camera
    depth_scale: float = 1.0
    cause: str | None = None


def _higher(by_m: float) -> Change:
    def change(camera: Camera) -> Camera:
        x, y, z = camera.position
        return replace(camera, position=(x, y, z + by_m))

    return change


def _turned(axis: Vector3, degrees: float) -> Change:
    """A rotation about one of the camera's own axes."""
    half = math.radians(degrees) / 2
    x, y, z = (math.sin(half) * part for part in axis)

    def change(camera: Camera) -> Camera:
        pose = camera.pose @ Pose((0.0, 0.0, 0.0), (x, y, z, math.cos(half)))
        return replace(camera, orientation=pose.orientation)

    return change


def _shifted(x_px: float, y_px: float) -> Change:
    return lambda camera: replace(camera, cx=camera.cx + x_px, cy=camera.cy + y_px)


def _zoomed(factor: float) -> Change:
    return lambda camera: replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)


def _in_millimetres(camera: Camera) -> Camera:
    x, y, z = (MILLIMETRES * length for length in camera.position)
    return replace(camera, position=(x, y, z))


def _w_first(camera: Camera) -> Camera:
    x, y, z, w = camera.orientation
    return replace(camera, orientation=(w, x, y, z))


def _inverted(camera: Camera) -> Camera:
    x, y, z, w = camera.orientation
    turned = Pose((0.0, 0.0, 0.0), (-x, -y, -z, w))
    x, y, z = (-length for length in camera.position)
    return replace(
        camera, position=(turned @ Pose((x, y, z))).position, orientation=turned.orientation
    )


RIGHT, DOWN, FORWARD = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

FAULTS = (
    Fault("none"),
    *(Fault(f"pose {by:+d} cm in height", _higher(by / 100)) for by in (-5, -2, -1, 1, 2, 5)),
    *(Fault(f"depths {by:+d} %", depth_scale=1.0 + PERCENT * by) for by in (-5, -2, 2, 5)),
    *(Fault(f"tilted by {by:+d} degrees", _turned(RIGHT, by)) for by in (-3, -1, 1, 3)),
    *(Fault(f"turned sideways by {by:+d} degrees", _turned(DOWN, by)) for by in (-5, -3, 3, 5)),
    *(Fault(f"rolled by {by:+d} degrees", _turned(FORWARD, by)) for by in (-5, -3, 3, 5)),
    *(Fault(f"principal point {by:+d} px in x", _shifted(by, 0)) for by in (-20, 20)),
    *(Fault(f"principal point {by:+d} px in y", _shifted(0, by)) for by in (-20, -10, 10, 20)),
    *(Fault(f"focal length {by:+d} %", _zoomed(1.0 + PERCENT * by)) for by in (-10, -5, 5, 10)),
    Fault("intrinsics of half the size", _zoomed(0.5)),
    Fault("depths in millimetres", depth_scale=MILLIMETRES, cause="depths_in_millimetres"),
    Fault("position in millimetres", _in_millimetres, cause="position_in_millimetres"),
    Fault("both in millimetres", _in_millimetres, MILLIMETRES, "lengths_in_millimetres"),
    Fault("orientation w, x, y, z", _w_first, cause="orientation_wxyz"),
    Fault("pose inverted", _inverted, cause="pose_inverted"),
    Fault("axes of OpenGL", _turned(RIGHT, 180.0), cause="axes_of_opengl"),
)
"""The first is no fault. Signed sizes are the reported minus the true value."""
