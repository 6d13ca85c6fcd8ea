"""Collision and distance checks: the arm's links, the hand and the held block against each
other, the table and the objects on it.

A configuration is free if no checked pair is closer than a margin. Trajectories are checked at
steps so small that no point moves farther than the margins in between, so nothing is touched
between two free configurations.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.bodies import Body, link_convex_hulls
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.manipulation.stability import TABLE
from nsrm_harness.manipulation.trajectory import Trajectory

HELD = "held"
MARGIN_M = 0.002
"""Minimum distance between all pairs that are not allowed to touch."""

ALLOWED_COLLISIONS: frozenset[frozenset[str]] = frozenset(
    frozenset(pair)
    for pair in (
        # Hulls of adjacent links overlap, or nearly touch, in every configuration.
        ("panda_link0", "panda_link1"),
        ("panda_link1", "panda_link2"),
        ("panda_link2", "panda_link3"),
        ("panda_link3", "panda_link4"),
        ("panda_link4", "panda_link5"),
        ("panda_link5", "panda_link6"),
        ("panda_link6", "panda_link7"),
        ("panda_link5", "panda_link7"),
        ("panda_link6", "panda_hand"),
        ("panda_link7", "panda_hand"),
        ("panda_hand", "panda_leftfinger"),
        ("panda_hand", "panda_rightfinger"),
        ("panda_link7", "panda_leftfinger"),
        ("panda_link7", "panda_rightfinger"),
        # The fingers hold a block, or close on each other.
        ("panda_leftfinger", "panda_rightfinger"),
        ("panda_leftfinger", HELD),
        ("panda_rightfinger", HELD),
        # The arm is bolted to the table.
        ("panda_link0", TABLE),
    )
)
"""The allowed collision matrix: pairs that are not checked, with the reason for each."""

SAMPLE_S = 0.0002
"""Sampling interval of a trajectory: at the maximum speed of all joints, no point moves more than
2.6 mm within it."""
FAR_M = 0.10
"""Distances beyond this are not computed: they would not allow more steps to be skipped."""
REACH_M = np.array([1.2, 1.2, 0.9, 0.9, 0.6, 0.5, 0.35])
"""Upper bounds of the distance from each joint's axis to any point it moves, the held block
included."""


@dataclass(frozen=True)
class Nearest:
    """The closest pair and its distance; 0 if the two touch."""

    pair: frozenset[str]
    distance_m: float

    def __str__(self) -> str:
        one, other = sorted(self.pair)
        if self.distance_m <= 0:
            return f"{one} would touch {other}"
        # The first pair that is too close on a path is so by little.
        return f"{one} would come within {math.ceil(1000 * self.distance_m)} mm of {other}"


class CollisionChecker:
    """Checks configurations of the arm against its surroundings and itself.

    * `objects`: the objects around the arm, by name, without the held one
    * `held`: the held block, in the hand's frame
    * `ignored`: pairs of names that may touch
    * `alive`: called for each configuration along a trajectory, because there are many
    """

    def __init__(
        self,
        kinematics: Kinematics,
        objects: Mapping[str, Cuboid],
        held: Cuboid | None = None,
        ignored: Iterable[tuple[str, str]] = (),
        alive: Callable[[], None] = lambda: None,
    ) -> None:
        self._kinematics, self._alive = kinematics, alive
        self._ignored = ALLOWED_COLLISIONS | {frozenset(pair) for pair in ignored}
        self._links = {link: Body.hull(link) for link in link_convex_hulls()}
        self._held = held
        if held is not None:
            self._links[HELD] = Body.box(held)
        # The table must be the last one.
        still = {**objects, TABLE: _TABLE}
        bodies = [*self._links.values(), *(Body.box(cuboid) for cuboid in still.values())]
        names = [*self._links, *still]
        moving = len(self._links)
        self._pairs = [
            (i, j)
            for i, j in combinations(range(len(names)), 2)
            if i < moving and frozenset((names[i], names[j])) not in self._ignored
        ]
        self._names, self._bodies = names, bodies
        # Where the moving bodies are, which are moved there once a distance from them is asked for.
        self._rotations = np.zeros((moving, 3, 3))
        self._positions = np.zeros((moving, 3))
        self._moving, self._unmoved = moving, set[int]()
        # Bounding spheres: those of the links move with their frames, the others stay.
        self._offsets = np.array([body.centre for body in self._links.values()])
        radii = np.array([body.radius_m for body in bodies])
        self._centres = np.zeros((len(names), 3))
        self._centres[moving:] = [cuboid.pose.position for cuboid in still.values()]
        first, second = np.array(self._pairs).T
        self._first, self._second = first, second
        self._reach = radii[first] + radii[second]
        # Everything lies within the table's sphere, so the height above its top is used instead.
        self._of_table = second == len(names) - 1
        self._radii = radii
        # How many bodies of each pair move, each of them at most as far as any point of the arm.
        self._movers = np.where(second < moving, 2, 1)

    def nearest(self, joints: Joints, opening_m: float) -> Nearest:
        """The closest pair in a configuration."""
        self._place(joints, opening_m)
        least = self._at_least_m()
        nearest, found = np.inf, (0, 0)
        for index in np.argsort(least):
            if least[index] >= nearest:
                break
            distance = self._distance_m(*self._pairs[index])
            if distance < nearest:
                nearest, found = distance, self._pairs[index]
        return Nearest(frozenset(self._names[body] for body in found), nearest)

    def touches(
        self, joints: Joints, opening_m: float, margin_m: float = MARGIN_M
    ) -> Nearest | None:
        """A pair that is closer than the margin, or None."""
        self._place(joints, opening_m)
        for index in np.flatnonzero(self._at_least_m() < margin_m):
            i, j = self._pairs[index]
            distance = self._distance_m(i, j)
            if distance < margin_m:
                return Nearest(frozenset((self._names[i], self._names[j])), distance)
        return None

    def _at_least_m(self) -> NDArray[np.float64]:
        """A lower bound of each pair's distance, from the bounding spheres."""
        between = self._centres[self._first] - self._centres[self._second]
        least = np.linalg.norm(between, axis=1) - self._reach
        above = self._centres[self._first, 2] - self._radii[self._first]
        return np.where(self._of_table, above, least)

    def along(self, trajectory: Trajectory, opening_m: float) -> Nearest | None:
        """The first contact along a trajectory; None if it is free.

        A pair that is farther apart than the margin stays so for a while: steps at which no point
        can have moved far enough to close the gap are skipped.
        """
        sampled = steps(trajectory, MARGIN_M)
        index = 0
        # A lower bound of each pair's distance, by how far apart it was and how far it has moved.
        known_m = np.zeros(len(self._pairs))
        while index < len(sampled.joints):
            self._alive()
            free_m = self.free_m(sampled.joints[index], opening_m, known_m)
            if free_m <= 0.0:
                touch = self.touches(sampled.joints[index], opening_m)
                if touch is not None:
                    return touch
                # The distance equals the margin to the last bit: free, and checked again at the
                # very next step.
            # All steps up to which no point has moved farther than that are free too.
            free = np.searchsorted(sampled.moved_m, sampled.moved_m[index] + free_m)
            last, index = index, max(index + 1, int(free))
            if index < len(sampled.joints):
                known_m -= self._movers * (sampled.moved_m[index] - sampled.moved_m[last])
        return None

    def free_m(
        self, joints: Joints, opening_m: float, known_m: NDArray[np.float64] | None = None
    ) -> float:
        """A lower bound, metres, of how far any point of the arm can move before a pair is as close
        as the margin; 0 or less if one already is, `FAR_M` at most.

        * `known_m`: lower bounds of the pairs' distances, as far as they are known; raised to what
          is found here
        """
        if known_m is None:
            known_m = np.zeros(len(self._pairs))
        self._place(joints, opening_m)
        np.maximum(known_m, self._at_least_m(), out=known_m)
        free_m = (known_m - MARGIN_M) / self._movers
        least_m = FAR_M
        for index in np.argsort(free_m):
            if free_m[index] >= least_m:
                break
            known_m[index] = self._distance_m(*self._pairs[index])
            least_m = min(least_m, (known_m[index] - MARGIN_M) / int(self._movers[index]))
        return float(least_m)

    def _place(self, joints: Joints, opening_m: float) -> None:
        frames = self._kinematics.links(joints, opening_m)
        for index, name in enumerate(self._links):
            rotation, position = frames[panda.HAND_FRAME if name == HELD else name]
            if name == HELD and self._held is not None:
                position = rotation @ self._held.pose.position + position
                rotation = rotation @ self._held.pose.rotation()
            self._rotations[index], self._positions[index] = rotation, position
        offsets = np.einsum("nij,nj->ni", self._rotations, self._offsets)
        self._centres[: self._moving] = self._positions + offsets
        self._unmoved = set(range(self._moving))

    def _distance_m(self, i: int, j: int) -> float:
        for index in self._unmoved.intersection((i, j)):
            self._bodies[index].move_to(self._rotations[index], self._positions[index])
            self._unmoved.remove(index)
        return self._bodies[i].distance_m(self._bodies[j])


@dataclass(frozen=True, eq=False)
class Steps:
    """Configurations along a trajectory.

    * `joints`: `[n, 7]`, radians
    * `moved_m`: `[n]`, upper bound of the distance that any point of the arm has moved up to each
    """

    joints: NDArray[np.float64]
    moved_m: NDArray[np.float64]


def steps(trajectory: Trajectory, margin_m: float) -> Steps:
    """Configurations from the beginning to the end of a trajectory. Between two of them, no point
    moves farther than twice the margin, so it is within one margin of either.

    * `margin_m`: at least 1.3 mm, half of the most that a point moves in `SAMPLE_S`
    """
    count = math.ceil(trajectory.duration_s / SAMPLE_S) + 1
    joints = trajectory.at(np.linspace(0.0, trajectory.duration_s, count)).joints
    moved_m = np.abs(np.diff(joints, axis=0)) @ REACH_M
    way_m = np.concatenate([[0.0], np.cumsum(moved_m)])
    # The first sample after each stride lies up to one sampling interval farther.
    stride_m = 2 * margin_m - float(moved_m.max(initial=0.0))
    marks = np.arange(0.0, way_m[-1], stride_m)
    looked = np.append(np.searchsorted(way_m, marks), count - 1)
    return Steps(joints[looked], way_m[looked])


_TABLE = Cuboid(Pose((0.40, 0.0, -0.02)), (1.20, 1.40, 0.04))
