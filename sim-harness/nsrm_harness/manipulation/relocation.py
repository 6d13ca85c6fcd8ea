"""Plans relocations: which blocks are moved aside, and where to, if only blocks that are too close
prevent a sub-goal. All of it is planned before anything moves."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from itertools import islice

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.stability import gap_m, resting_on, supporting

MAX_BLOCKERS = 2
"""Maximum number of blocks that are moved aside for one sub-goal."""
MAX_PLACES = 6
"""Maximum number of free places for which a blocker's motions are planned."""
MAX_PLANS = 20
"""Maximum number of pick and place plans in one search: it ends by a count, not by time."""
LOWEST_M, HIGHEST_M = (0.36, -0.24), (0.64, 0.24)
"""Bounds of a blocker's new centre, x and y: there the arm reaches it from above at any yaw, and
the camera sees it whole. The blocks start there."""
STEP_M = 0.01
"""Spacing of the candidate places."""
FINGER_ROOM_M = 0.034
"""Minimum room around a blocker in its new place: a finger is 26 mm thick, passes 3 mm from the
block and keeps 2 mm from the next one; the rest is for perception errors."""

Relocation = tuple[str, Pose]
"""The name of the object that is carried first, and the pose at which its centre is put."""


def plan_relocations(
    planner: PickAndPlacePlanner,
    objects: Mapping[str, Cuboid],
    name: str,
    goal: Pose,
    begin: Joints,
    refusal: RefusedError,
    keep: Collection[str] = (),
) -> tuple[Relocation, ...]:
    """Which blocks are moved aside, in this order, so that a block can be carried to its sub-goal;
    empty if nothing is found. As few blockers as possible, each to one of the nearest places.
    Deterministic.

    * `objects`: all objects that are seen, by name
    * `begin`: the current joints
    * `refusal`: why the block cannot be carried as things stand
    * `keep`: names of the objects that must stay where they are, besides those that the block is
      put on

    An object that supports something stays too. Bounded: at most `MAX_PLANS` pick and place plans.
    """
    if refusal.why not in (RefusalReason.NO_ROOM, RefusalReason.NO_PATH):
        return ()
    return _Search(planner, objects, name, goal, begin, keep).relocations(refusal)


class _Search:
    def __init__(
        self,
        planner: PickAndPlacePlanner,
        objects: Mapping[str, Cuboid],
        name: str,
        goal: Pose,
        begin: Joints,
        keep: Collection[str],
    ) -> None:
        self._planner, self._objects = planner, objects
        self._name, self._goal, self._begin = name, goal, begin
        self._there = Cuboid(goal, objects[name].edges_m)
        self._movable = {
            key for key, cuboid in objects.items() if not resting_on(cuboid, _without(objects, key))
        }
        self._movable -= {name, *keep, *supporting(self._there, objects)}
        self._refusals: dict[frozenset[str], RefusedError | None] = {}
        self._plans = 0

    def relocations(self, refusal: RefusedError) -> tuple[Relocation, ...]:
        """The relocations: with one blocker first, then with more."""
        refusals: dict[tuple[str, ...], RefusedError] = {(): refusal}
        for _ in range(MAX_BLOCKERS):
            further: dict[tuple[str, ...], RefusedError] = {}
            for gone, why in refusals.items():
                for blocker in why.in_the_way:
                    if blocker not in self._movable:
                        continue
                    blockers = (*gone, blocker)
                    still = self._refusal_without(frozenset(blockers))
                    if still is not None:
                        further[blockers] = still
                    elif found := self._places(blockers):
                        return found
            refusals = further
        return ()

    def _places(self, blockers: tuple[str, ...]) -> tuple[Relocation, ...]:
        """The new place of each blocker in turn; empty if one of them has none."""
        objects, begin = self._objects, self._begin
        found: list[Relocation] = []
        for number, blocker in enumerate(blockers, start=1):
            place = self._place(objects, blocker, blockers[number:], begin)
            if place is None:
                return ()
            found.append((blocker, place))
            objects = {**objects, blocker: Cuboid(place, objects[blocker].edges_m)}
            begin = panda.READY_RAD
        return tuple(found)

    def _place(
        self, objects: Mapping[str, Cuboid], blocker: str, later: tuple[str, ...], begin: Joints
    ) -> Pose | None:
        """The nearest place to which the blocker can be carried, and at which it no longer prevents
        the block's sub-goal once the later blockers are moved too."""
        block = objects[blocker]
        others = [*_without(objects, blocker).values(), self._there]
        for place in islice(with_room(block, others), MAX_PLACES):
            moved = {**objects, blocker: Cuboid(place, block.edges_m)}
            if self._refusal(_without(moved, *later)) is None and (
                self._plan(objects, blocker, place, begin) is None
            ):
                return place
        return None

    def _refusal_without(self, gone: frozenset[str]) -> RefusedError | None:
        if gone not in self._refusals:
            self._refusals[gone] = self._refusal(_without(self._objects, *gone))
        return self._refusals[gone]

    def _refusal(self, objects: Mapping[str, Cuboid]) -> RefusedError | None:
        """Why the block cannot be carried to its sub-goal among these objects, from the ready
        pose."""
        return self._plan(objects, self._name, self._goal, panda.READY_RAD)

    def _plan(
        self, objects: Mapping[str, Cuboid], name: str, goal: Pose, begin: Joints
    ) -> RefusedError | None:
        if self._plans == MAX_PLANS:
            # Names nothing in the way, so the search ends.
            return RefusedError(RefusalReason.NO_PATH, f"gave up after {MAX_PLANS} plans")
        self._plans += 1
        try:
            self._planner.carry(objects, name, goal, begin, leaning=False)
        except RefusedError as refusal:
            return refusal
        return None


def with_room(block: Cuboid, others: Collection[Cuboid]) -> Iterator[Pose]:
    """Places of a block on the table with room for the fingers all around it, at its current yaw,
    nearest first."""
    x, y, _ = block.pose.position
    places = sorted(_grid(), key=lambda place: (math.dist(place, (x, y)), place))
    for place in places:
        pose = Pose.upright(*place, block.edges_m[2] / 2, block.pose.yaw_rad())
        put = Cuboid(pose, block.edges_m)
        if all(gap_m(put, other) >= FINGER_ROOM_M for other in others):
            yield pose


def _grid() -> list[tuple[float, float]]:
    xs, ys = (
        [round(low + STEP_M * number, 6) for number in range(round((high - low) / STEP_M) + 1)]
        for low, high in zip(LOWEST_M, HIGHEST_M, strict=True)
    )
    return [(x, y) for x in xs for y in ys]


def _without(objects: Mapping[str, Cuboid], *names: str) -> dict[str, Cuboid]:
    return {name: cuboid for name, cuboid in objects.items() if name not in names}
