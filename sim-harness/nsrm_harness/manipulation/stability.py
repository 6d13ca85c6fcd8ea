"""Whether a block can stand where it is to be put: what is under it, whether it has room
there, and whether it would fall. By what is seen, before anything moves."""

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
    """What a block would be put on, if that is near enough to its foot."""
    return {
        name: other
        for name, other in others.items()
        if abs(other.top_m - wanted.bottom_m) <= LEVEL_M and _overlap(wanted, other).area > 0
    }


def resting_on(block: Cuboid, others: Mapping[K, Cuboid]) -> list[K]:
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
            RefusalReason.NO_ROOM,
            f"it would be {1000 * least_m:.0f} mm from {near[-1]}; {1000 * ROOM_M:.0f} mm are kept",
            tuple(near),
        )


def _check_stability(
    placed: Cuboid, under: Mapping[str, Cuboid], others: Mapping[str, Cuboid]
) -> None:
    """Of the block on what is under it, and then of what is under it, with all that it bears, on
    each lower level. A block on the table stands whatever it bears."""
    tower, fast = {_PLACED: placed}, dict(under)
    while fast:
        whole = _with_loads(tower, others)
        stands = _stands(whole, under, others)
        if not stands and not _stands(_without_placed(whole), under, others):
            # By what is seen the others would have fallen, though they stand: one of them is
            # seen a little off. They are left out.
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
"""Among the others' names: nothing is called so."""


def _with_loads(tower: Mapping[str, Cuboid], others: Mapping[str, Cuboid]) -> dict[str, Cuboid]:
    """These and all that stands on any of them but the block that is placed: by what is seen
    nothing stands on that."""
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
    """The names of what one of the others stands on."""
    return standing_on(others[name], {key: other for key, other in others.items() if key != name})


def _stands(
    blocks: Mapping[str, Cuboid], under: Mapping[str, Cuboid], others: Mapping[str, Cuboid]
) -> bool:
    """Whether some blocks stand together if all else stands fast: whether there are forces, upward
    and in places where one touches another, that bear each block's weight and what presses on
    it without turning it over. Of one block on others: whether its centre of mass lies within
    the support polygon.

    * `under`: what the block that is placed stands on
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
    # Shares of the whole weight, so that its tolerances mean the same for all blocks.
    shares = weights / sum(_volume(block) for block in blocks.values())
    found = linprog(np.zeros(len(forces)), A_eq=np.array(forces).T, b_eq=shares)
    return bool(found.status == 0)


def _moment(x: float, y: float) -> NDArray[np.float64]:
    """A force of 1 upward there, and how it turns about the axes; decimetres, so that all are
    of one size."""
    return np.array([1.0, 10 * x, 10 * y])


def _bearing(block: Cuboid, feet: Mapping[str, Cuboid]) -> Iterator[tuple[str, float, float]]:
    """Where a block is borne: by which of its feet, and x and y. The corners of where they touch,
    drawn by `STABLE_M` into what lies between all of them. Without feet, the table's."""
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
