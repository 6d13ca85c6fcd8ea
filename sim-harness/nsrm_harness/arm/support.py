"""Whether a block can stand where it is to be put: what is under it, whether it has room
there, and whether it would fall. By what is seen, before anything moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from shapely import Point, Polygon, unary_union
from shapely.geometry.base import BaseGeometry

from nsrm_harness.arm.refused import RefusedError, Why
from nsrm_harness.perception.cuboids import Cuboid
from nsrm_harness.world.pose import Pose

TABLE = "table"

LEVEL_M = 0.012
"""A sub-goal's foot may be so much above or below what is seen under it: it is put right."""
CENTRED_M = 0.008
"""A sub-goal on one block that is off its middle by no more than that is put right."""
ROOM_M = 0.004
"""Between a block where it is put and its neighbours, at least."""
STABLE_M = 0.003
"""The centre of mass lies within the support by at least that."""
TOUCH_M = 0.003
"""Two faces, of which one is seen to lie above the other by no more than that, touch."""


@dataclass(frozen=True)
class Placement:
    """Where a block is put.

    * `cuboid`: the block there
    * `support`: the names of what it stands on
    * `corrected_m`: how far that is from the sub-goal
    """

    cuboid: Cuboid
    support: tuple[str, ...]
    corrected_m: float


def placement(goal: Pose, block: Cuboid, others: Mapping[str, Cuboid]) -> Placement:
    """The sub-goal, put right by millimetres where what is seen under it says so.

    * `goal`: of the block's centre, upright
    * `others`: all that stands there but the block, by name

    Raises `RefusedError` where it would fall, has nothing under it or has no room.
    """
    foot_m = goal.position[2] - block.edges_m[2] / 2
    wanted = Cuboid(goal, block.edges_m)
    under = supporting(wanted, others)
    level_m = max((other.top_m for other in under.values()), default=0.0)
    if not under and abs(foot_m) > LEVEL_M:
        what = "above the table with nothing under it" if foot_m > 0 else "below the table's top"
        raise RefusedError(
            Why.NO_SUPPORT,
            f"the sub-goal's foot is {1000 * abs(foot_m):.0f} mm {what}",
        )
    under = {name: other for name, other in under.items() if level_m - other.top_m <= TOUCH_M}
    x, y, _ = goal.position
    if len(under) == 1:
        (base,) = under.values()
        centre_x, centre_y, _ = base.pose.position
        if math.dist((x, y), (centre_x, centre_y)) <= CENTRED_M:
            x, y = centre_x, centre_y
    pose = Pose((x, y, level_m + block.edges_m[2] / 2), goal.orientation)
    placed = Cuboid(pose, block.edges_m)
    _check_room(placed, {name: other for name, other in others.items() if name not in under})
    _check_stability(placed, under, others)
    return Placement(placed, tuple(under) or (TABLE,), pose.distance_m(goal))


def supporting(wanted: Cuboid, others: Mapping[str, Cuboid]) -> dict[str, Cuboid]:
    """What a block would be put on, if that is near enough to its foot."""
    return {
        name: other
        for name, other in others.items()
        if abs(other.top_m - wanted.bottom_m) <= LEVEL_M and _overlap(wanted, other).area > 0
    }


def resting_on(block: Cuboid, others: Mapping[str, Cuboid]) -> list[str]:
    """The names of what stands on a block."""
    return [
        name
        for name, other in others.items()
        if abs(other.bottom_m - block.top_m) <= TOUCH_M and _overlap(block, other).area > 0
    ]


def standing_on(block: Cuboid, others: Mapping[str, Cuboid]) -> list[str]:
    """The names of what a block stands on; the table if there is nothing else."""
    under = [
        name
        for name, other in others.items()
        if abs(block.bottom_m - other.top_m) <= TOUCH_M and _overlap(block, other).area > 0
    ]
    return under or [TABLE]


def gap_m(one: Cuboid, other: Cuboid) -> float:
    """Between two, as seen from above."""
    return _plan(one).distance(_plan(other))


def _check_room(placed: Cuboid, others: Mapping[str, Cuboid]) -> None:
    near = []
    for name, other in others.items():
        beside_m = min(placed.top_m, other.top_m) - max(placed.bottom_m, other.bottom_m)
        if beside_m > TOUCH_M and gap_m(placed, other) < ROOM_M:
            near.append(name)
    if near:
        near.sort(key=lambda name: gap_m(placed, others[name]), reverse=True)
        least_m = gap_m(placed, others[near[-1]])
        raise RefusedError(
            Why.NO_ROOM,
            f"it would be {1000 * least_m:.0f} mm from {near[-1]}; {1000 * ROOM_M:.0f} mm are kept",
            tuple(near),
        )


def _check_stability(
    placed: Cuboid, under: Mapping[str, Cuboid], others: Mapping[str, Cuboid]
) -> None:
    """Of the block on what is under it, and of the tower that it tops on each lower one."""
    tower = [placed]
    while under:
        mass = sum(_volume(block) for block in tower)
        x, y = (
            sum(_volume(block) * block.pose.position[axis] for block in tower) / mass
            for axis in (0, 1)
        )
        support = unary_union([_overlap(tower[-1], base) for base in under.values()]).convex_hull
        if not support.buffer(-STABLE_M).contains(Point(x, y)):
            names = " and ".join(under)
            what = "it" if len(tower) == 1 else "the tower"
            raise RefusedError(
                Why.UNSTABLE,
                f"{what} would fall from {names}: its centre of mass is not above it",
            )
        if len(under) > 1:
            # What each of them bears can't be told.
            return
        (base,) = under.values()
        tower.append(base)
        names = standing_on(base, {k: other for k, other in others.items() if other is not base})
        under = {name: others[name] for name in names if name != TABLE}


def _plan(cuboid: Cuboid) -> Polygon:
    return Polygon(cuboid.corners())


def _overlap(one: Cuboid, other: Cuboid) -> BaseGeometry:
    return _plan(one).intersection(_plan(other))


def _volume(cuboid: Cuboid) -> float:
    a, b, c = cuboid.edges_m
    return a * b * c
