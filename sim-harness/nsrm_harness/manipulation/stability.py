"""Checks whether a block can stand at its sub-goal: its support, its room and its stability. Uses
what is seen, before anything moves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from shapely import Point, Polygon, get_coordinates, unary_union
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError

K = TypeVar("K")

TABLE = "table"

LEVEL_M = 0.012
"""Maximum difference in height between a sub-goal's foot and the support that is seen below it; the
sub-goal is corrected to that support."""
CENTRED_M = 0.008
"""A sub-goal that is off the middle of a single block by no more than this is moved to it."""
ROOM_M = 0.004
"""Minimum room between a block at its target and its neighbours."""
STABLE_M = 0.003
"""Minimum distance of the centre of mass from the edge of the support."""
TOUCH_M = 0.003
"""Two faces touch if one is seen above the other by no more than this."""


@dataclass(frozen=True)
class Placement:
    """Where a block is put.

    * `cuboid`: the block there
    * `support`: names of the objects that it stands on
    * `corrected_m`: distance from the sub-goal
    """

    cuboid: Cuboid
    support: tuple[str, ...]
    corrected_m: float


def placement(goal: Pose, block: Cuboid, others: Mapping[str, Cuboid]) -> Placement:
    """The sub-goal, corrected by millimetres to match the support that is seen below it.

    * `goal`: pose of the block's centre, upright
    * `others`: all other objects, by name

    Raises `RefusedError` if the block would fall, or has no support or no room.
    """
    foot_m = goal.position[2] - block.edges_m[2] / 2
    wanted = Cuboid(goal, block.edges_m)
    under = supporting(wanted, others)
    level_m = max((other.top_m for other in under.values()), default=0.0)
    if not under and abs(foot_m) > LEVEL_M:
        what = "above the table with nothing under it" if foot_m > 0 else "below the table's top"
        raise RefusedError(
            RefusalReason.NO_SUPPORT,
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
    """The objects that a block would be put on, if they are close enough to its foot."""
    return {
        name: other
        for name, other in others.items()
        if abs(other.top_m - wanted.bottom_m) <= LEVEL_M and _overlap(wanted, other).area > 0
    }


def resting_on(block: Cuboid, others: Mapping[K, Cuboid]) -> list[K]:
    """The names of the objects that stand on a block."""
    return [
        name
        for name, other in others.items()
        if abs(other.bottom_m - block.top_m) <= TOUCH_M and _overlap(block, other).area > 0
    ]


def standing_on(block: Cuboid, others: Mapping[str, Cuboid]) -> list[str]:
    """The names of the objects that a block stands on; the table if there are none."""
    under = [
        name
        for name, other in others.items()
        if abs(block.bottom_m - other.top_m) <= TOUCH_M and _overlap(block, other).area > 0
    ]
    return under or [TABLE]


def gap_m(one: Cuboid, other: Cuboid) -> float:
    """The distance between two cuboids, as seen from above."""
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
            RefusalReason.NO_ROOM,
            f"it would be {1000 * least_m:.0f} mm from {near[-1]}; {1000 * ROOM_M:.0f} mm are kept",
            tuple(near),
        )


def _check_stability(
    placed: Cuboid, under: Mapping[str, Cuboid], others: Mapping[str, Cuboid]
) -> None:
    """Checks the block on its support, and then each lower level of the support with everything
    that it carries. A block on the table stands whatever it carries."""
    tower, fast = {_PLACED: placed}, dict(under)
    while fast:
        whole = _with_loads(tower, others)
        stands = _stands(whole, under, others)
        if not stands and not _stands(_without_placed(whole), under, others):
            # By what is seen, the others would have fallen although they stand: one of them is seen
            # slightly off. They are left out.
            stands = _stands(tower, under, others)
        if not stands:
            what = "it" if len(tower) == 1 else "the tower"
            raise RefusedError(
                RefusalReason.UNSTABLE,
                f"{what} would fall from {' and '.join(fast)}: its centre of mass is not above it",
            )
        tower |= fast
        names = {name for base in fast for name in _feet(base, others)}
        fast = {name: others[name] for name in sorted(names - {TABLE, *tower})}


_PLACED = ""
"""The placed block's name among the others: no object has it."""


def _with_loads(tower: Mapping[str, Cuboid], others: Mapping[str, Cuboid]) -> dict[str, Cuboid]:
    """These blocks and everything that stands on any of them, except the placed block: nothing is
    seen standing on that one."""
    whole = dict(tower)
    left = [name for name in tower if name != _PLACED]
    while left:
        for name in resting_on(whole[left.pop()], others):
            if name not in whole:
                whole[name] = others[name]
                left.append(name)
    return whole


def _without_placed(blocks: Mapping[str, Cuboid]) -> dict[str, Cuboid]:
    return {name: block for name, block in blocks.items() if name != _PLACED}


def _feet(name: str, others: Mapping[str, Cuboid]) -> list[str]:
    """The names of the objects that one of the others stands on."""
    return standing_on(others[name], {key: other for key, other in others.items() if key != name})


def _stands(
    blocks: Mapping[str, Cuboid], under: Mapping[str, Cuboid], others: Mapping[str, Cuboid]
) -> bool:
    """Whether these blocks stand together if everything else is fixed: whether there are upward
    forces at the contacts that carry each block's weight and loads without tipping it over. For one
    block on others, that means that the centre of mass lies within the support polygon.

    * `under`: the support of the placed block
    """
    rows = {name: 3 * number for number, name in enumerate(blocks)}
    weights = np.zeros(3 * len(rows))
    forces: list[NDArray[np.float64]] = []
    for name, block in blocks.items():
        row = rows[name]
        weights[row : row + 3] = _volume(block) * _moment(*block.pose.position[:2])
        feet = list(under) if name == _PLACED else _feet(name, others)
        for foot, x, y in _bearing(block, {key: others[key] for key in feet if key != TABLE}):
            force = np.zeros_like(weights)
            force[row : row + 3] = _moment(x, y)
            if foot in rows:
                force[rows[foot] : rows[foot] + 3] = -_moment(x, y)
            forces.append(force)
    if not rows:
        return True
    if not forces:
        return False
    # As fractions of the total weight, so that the solver's tolerances mean the same for all
    # blocks.
    shares = weights / sum(_volume(block) for block in blocks.values())
    found = linprog(np.zeros(len(forces)), A_eq=np.array(forces).T, b_eq=shares)
    return bool(found.status == 0)


def _moment(x: float, y: float) -> NDArray[np.float64]:
    """A unit upward force at this point, and its moments about the axes, in decimetres, so that all
    have a similar magnitude."""
    return np.array([1.0, 10 * x, 10 * y])


def _bearing(block: Cuboid, feet: Mapping[str, Cuboid]) -> Iterator[tuple[str, float, float]]:
    """The points at which a block is supported: by which foot, x and y. They are the corners of the
    contact areas, each moved to the nearest point of the convex hull of all areas, shrunk by
    `STABLE_M`. Without feet, the block's corners on the table."""
    if not feet:
        for x, y in block.corners():
            yield TABLE, float(x), float(y)
        return
    touching = {name: _overlap(block, foot) for name, foot in feet.items()}
    within = unary_union([*touching.values()]).convex_hull.buffer(-STABLE_M)
    if within.is_empty:
        return
    for name, area in touching.items():
        for corner in get_coordinates(area):
            x, y = get_coordinates(nearest_points(within, Point(corner))[0])[0]
            yield name, float(x), float(y)


def _plan(cuboid: Cuboid) -> Polygon:
    return Polygon(cuboid.corners())


def _overlap(one: Cuboid, other: Cuboid) -> BaseGeometry:
    return _plan(one).intersection(_plan(other))


def _volume(cuboid: Cuboid) -> float:
    a, b, c = cuboid.edges_m
    return a * b * c
