"""Samples initial poses of blocks: within reach, apart, and seen by the camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.simulation.blocks import Block


@dataclass(frozen=True)
class Space:
    """An upright box in the world, in metres."""

    min: Vector3
    max: Vector3

    def contains(self, position: Vector3) -> bool:
        """Whether the point lies inside or on the boundary."""
        return all(
            low <= value <= high
            for low, value, high in zip(self.min, position, self.max, strict=True)
        )

    def shrunk(self, margin_m: float) -> Space:
        """The same box, smaller by `margin_m` on each side in x and y."""
        (x0, y0, z0), (x1, y1, z1) = self.min, self.max
        return Space((x0 + margin_m, y0 + margin_m, z0), (x1 - margin_m, y1 - margin_m, z1))


WORK_SPACE = Space((0.35, -0.25, 0.0), (0.65, 0.25, 0.18))
"""Workspace of block centres: the arm reaches every point of it from above at any yaw, and the
default camera sees every block in it completely."""

PLACEMENT_SPACE = WORK_SPACE.shrunk(0.01)
"""Where blocks are placed on purpose: an estimate with an error of a few millimetres is still
inside the workspace."""

MAX_YAW_RAD = math.radians(10.0)
CLEARANCE_M = 0.012
"""Smallest initial gap between two blocks."""

MAX_TRIES = 2000


class LayoutError(HarnessError):
    """No place for a block was found in a bounded number of tries."""


Corners = tuple[tuple[float, float], ...]
"""Corners of a convex shape seen from above, x and y in metres, counter-clockwise."""


@lru_cache(maxsize=4096)
def footprint(block: Block, pose: Pose) -> Corners:
    """The four corners of the block's base."""
    hx, hy = block.edges_m[0] / 2, block.edges_m[1] / 2
    x, y, _ = pose.position
    yaw = pose.yaw_rad()
    cos, sin = math.cos(yaw), math.sin(yaw)
    return tuple(
        (x + dx * cos - dy * sin, y + dx * sin + dy * cos)
        for dx, dy in ((-hx, -hy), (hx, -hy), (hx, hy), (-hx, hy))
    )


def apart(a: Corners, b: Corners, gap_m: float) -> bool:
    """Whether a straight strip at least `gap_m` wide separates two convex shapes.

    It tests only the edges' separating axes: two corners facing each other may count as closer than
    they are, never as farther.
    """
    # Planning calls this thousands of times per episode: arrays with four rows would cost more than
    # the computation.
    return _edge_parts(a, b, gap_m) or _edge_parts(b, a, gap_m)


def _edge_parts(own: Corners, other: Corners, gap_m: float) -> bool:
    """Whether all of `other` is beyond a strip along one of the edges of `own`."""
    x0, y0 = own[-1]
    for x1, y1 in own:
        # The outward normal of an edge of a shape with counter-clockwise corners.
        nx, ny = y1 - y0, x0 - x1
        length = math.hypot(nx, ny)
        if min(nx * (x - x0) + ny * (y - y0) for x, y in other) >= gap_m * length:
            return True
        x0, y0 = x1, y1
    return False


def sample_layout(
    rng: np.random.Generator,
    blocks: Sequence[Block],
    *,
    around: Sequence[Corners] = (),
    space: Space = PLACEMENT_SPACE,
    clearance_m: float = CLEARANCE_M,
    max_yaw_rad: float = MAX_YAW_RAD,
) -> list[Pose]:
    """Samples a pose on the table for each block, in order: uniform in `space`, yaw within
    `max_yaw_rad`, at least `clearance_m` between any two.

    * `around`: footprints that are already taken

    Raises `LayoutError` after `MAX_TRIES` draws.
    """
    poses: list[Pose] = []
    taken = list(around)
    tries = 0
    while len(poses) < len(blocks):
        if tries == MAX_TRIES:
            raise LayoutError(
                f"no place for block {len(poses) + 1} of {len(blocks)} after {MAX_TRIES} tries: "
                f"use fewer blocks, or a workspace larger than {space.min} to {space.max} m"
            )
        tries += 1
        block = blocks[len(poses)]
        pose = Pose.upright(
            float(rng.uniform(space.min[0], space.max[0])),
            float(rng.uniform(space.min[1], space.max[1])),
            block.edges_m[2] / 2,
            float(rng.uniform(-max_yaw_rad, max_yaw_rad)),
        )
        corners = footprint(block, pose)
        if all(apart(corners, other, clearance_m) for other in taken):
            poses.append(pose)
            taken.append(corners)
    return poses
