"""Candidate grasps of a block: from above, with the fingers on two opposite faces."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose

HEIGHTS_M = (0.0, 0.006, 0.010, 0.014)
"""Heights of the fingertips above the block's middle: the higher ones keep the palm off a taller
neighbour."""
UPRIGHT = (0.0,)
LEANS_RAD = (*UPRIGHT, 0.35, -0.35, 0.6, -0.6)
"""Tilts of the hand along the faces that it holds: a tilt keeps its upper part off a tower."""
HELD_M = 0.010
"""Minimum overlap of the fingers with the block, in height."""
CLEAR_M = 0.003
"""Clearance between each finger and the block before the fingers close."""
NARROW_M = 0.002
"""The same between neighbours that leave no more room: the margin that fingers keep from those."""
MIDDLE = (0.0,)
ASIDE = (1 / 6, -1 / 6, 1 / 4, -1 / 4)
"""Offsets of the hand from the middle of the faces that it holds, as fractions of their width: for
a neighbour that stands in front of only a part of a face."""
HOLDS = ((MIDDLE, CLEAR_M), (ASIDE, CLEAR_M), ((*MIDDLE, *ASIDE), NARROW_M))
"""Offsets on the faces and clearances, tried in this order, each with all other choices."""
WIDEST_M = panda.MAX_OPENING_M - CLEAR_M
"""Maximum width of a block that can be grasped: the hand has to open slightly wider."""
LOWEST_M = 2 * (min(HEIGHTS_M) + HELD_M)
"""Minimum height of a block that can be grasped: the fingertips are at its middle or above."""


@dataclass(frozen=True)
class Grasp:
    """One grasp of a block.

    * `hand`: the hand's frame in the world
    * `width_m`: opening of the fingers when they hold the block
    * `lean_rad`: tilt of the hand from pointing straight down
    * `clear_m`: clearance between each finger and the block before the fingers close, and after
      they release it
    * `opening_m`: opening of the fingers at that clearance
    """

    hand: Pose
    width_m: float
    lean_rad: float = 0.0
    clear_m: float = CLEAR_M

    @property
    def opening_m(self) -> float:
        return min(self.width_m + 2 * self.clear_m, panda.MAX_OPENING_M)


def pointing_down(x: float, y: float, z: float, yaw_rad: float, lean_rad: float = 0.0) -> Pose:
    """The hand's pose with its fingertips at this point. It closes along y, rotated by the yaw, and
    is tilted about that line."""
    turn = (math.cos(yaw_rad / 2), math.sin(yaw_rad / 2), 0.0, 0.0)
    if lean_rad == 0.0:
        return Pose((x, y, z + panda.FINGERTIP_M), turn)
    lean = Pose((0.0, 0.0, 0.0), (0.0, math.sin(lean_rad / 2), 0.0, math.cos(lean_rad / 2)))
    return Pose((x, y, z), turn) @ lean @ Pose((0.0, 0.0, -panda.FINGERTIP_M))


def grasps(
    block: Cuboid,
    leans_rad: Sequence[float] = LEANS_RAD,
    places: Sequence[float] = MIDDLE,
    clear_m: float = CLEAR_M,
) -> list[Grasp]:
    """All grasps of a block with these tilts and offsets, on each pair of faces and at each
    height."""
    x, y, z = block.pose.position
    found = []
    for lean_rad, height_m in itertools.product(leans_rad, HEIGHTS_M):
        if block.edges_m[2] / 2 - height_m < HELD_M:
            continue
        for quarter, place in itertools.product(range(4), places):
            # With the block's yaw, the hand closes along the block's y.
            width_m = block.edges_m[quarter % 2]
            if width_m > WIDEST_M:
                continue
            yaw_rad = block.pose.yaw_rad() + (quarter - 1) * math.pi / 2
            aside_m = place * block.edges_m[1 - quarter % 2]
            hand = pointing_down(
                x + aside_m * math.cos(yaw_rad),
                y + aside_m * math.sin(yaw_rad),
                z + height_m,
                yaw_rad,
                lean_rad,
            )
            found.append(Grasp(hand, width_m, lean_rad, clear_m))
    return found


def why_not_held(block: Cuboid) -> str:
    """Which dimensions of a block rule out every grasp; empty if none does."""
    why = []
    narrow_m, high_m = min(block.edges_m[:2]), block.edges_m[2]
    if narrow_m > WIDEST_M:
        why.append(
            f"it is {1000 * narrow_m:.1f} mm wide where it is narrowest, and the hand holds "
            f"{1000 * WIDEST_M:.1f} mm at most"
        )
    if high_m / 2 - min(HEIGHTS_M) < HELD_M:
        why.append(
            f"it is {1000 * high_m:.1f} mm high, and the fingers need {1000 * LOWEST_M:.1f} mm"
        )
    return "; ".join(why)
