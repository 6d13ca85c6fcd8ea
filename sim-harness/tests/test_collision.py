"""Collision checks: distances against PyBullet and coal, and the spacing of checks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import nnls

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.bodies import Body, link_convex_hulls
from nsrm_harness.manipulation.collision import (
    ALLOWED_COLLISIONS,
    FAR_M,
    HELD,
    MARGIN_M,
    REACH_M,
    CollisionChecker,
    steps,
)
from nsrm_harness.manipulation.grasps import pointing_down
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.manipulation.paths import line
from nsrm_harness.manipulation.stability import TABLE
from nsrm_harness.manipulation.trajectory import Along, Straight, Trajectory
from nsrm_harness.simulation.bullet import connect_direct, pybullet
from nsrm_harness.simulation.layout import WORK_SPACE

# Its types are made when it is loaded.
coal: Any = import_module("coal")

KINEMATICS = Kinematics()
LINKS = tuple(link_convex_hulls())

HULL_M = 0.001
"""PyBullet rounds a link's hull off by its collision margin of 1 mm, after having made the hull
smaller by part of that: it is 0.2 to 1 mm nearer to everything than ours. Its boxes are as large
as they are said to be."""
EXACT_M = 2e-5
COAL_M = 1e-6
"""To which both iterate."""
OPEN_M = panda.MAX_OPENING_M
IN_HAND = Cuboid(Pose.upright(0.0, 0.01, panda.FINGERTIP_M, 0.4), (0.06, 0.03, 0.04))


@dataclass(frozen=True)
class Other:
    """The arm in PyBullet, whose answers are compared with."""

    client: int
    arm: int
    links: dict[str, int]
    revolute: list[int]
    fingers: list[int]

    def turn(self, joints: Joints, opening_m: float) -> None:
        values = [*joints.tolist(), opening_m / 2, opening_m / 2]
        for joint, value in zip([*self.revolute, *self.fingers], values, strict=True):
            pybullet.resetJointState(self.arm, joint, value, physicsClientId=self.client)

    def add(self, cuboid: Cuboid) -> int:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=[edge / 2 for edge in cuboid.edges_m],
            physicsClientId=self.client,
        )
        return pybullet.createMultiBody(
            0,
            shape,
            basePosition=cuboid.pose.position,
            baseOrientation=cuboid.pose.orientation,
            physicsClientId=self.client,
        )

    def remove(self, body: int) -> None:
        pybullet.removeBody(body, physicsClientId=self.client)

    def distance_m(self, link: str, body: int, other: str | None = None) -> float:
        """From a link to a body without links, or to another link; below 0 where they overlap."""
        second = {} if other is None else {"linkIndexB": self.links[other]}
        points = pybullet.getClosestPoints(
            self.arm,
            body,
            3.0,
            linkIndexA=self.links[link],
            physicsClientId=self.client,
            **second,
        )
        return min(point[8] for point in points)


@pytest.fixture(scope="module")
def other() -> Iterator[Other]:
    client = connect_direct()
    arm = pybullet.loadURDF(str(panda.URDF), useFixedBase=True, physicsClientId=client)
    infos = [
        pybullet.getJointInfo(arm, joint, physicsClientId=client)
        for joint in range(pybullet.getNumJoints(arm, physicsClientId=client))
    ]
    yield Other(
        client,
        arm,
        {"panda_link0": -1, **{info[12].decode(): info[0] for info in infos}},
        [info[0] for info in infos if info[2] == pybullet.JOINT_REVOLUTE],
        [info[0] for info in infos if info[2] == pybullet.JOINT_PRISMATIC],
    )
    pybullet.disconnect(physicsClientId=client)


def coal_hull(link: str) -> Any:
    """The hull of a link's corners, as coal makes it."""
    corners = coal.StdVec_Vec3s()
    corners.extend(list(link_convex_hulls()[link].vertices))
    return coal.Convex.convexHull(corners, True, "")


def coal_distance(
    shape: Any,
    frame: tuple[NDArray[np.float64], NDArray[np.float64]],
    box: Cuboid,
) -> tuple[float, NDArray[np.float64]]:
    """How far a box is from a shape, metres, below 0 where they overlap; and in which direction."""
    result = coal.DistanceResult()
    distance_m = coal.distance(
        shape,
        coal.Transform3s(*frame),
        coal.Box(*box.edges_m),
        coal.Transform3s(box.pose.rotation(), np.array(box.pose.position)),
        coal.DistanceRequest(),
        result,
    )
    return float(distance_m), result.normal


def distance_m(
    body: str, box: Cuboid, held: Cuboid | None, joints: Joints, opening_m: float
) -> float:
    """How far a body is from a box by the checker that is tested; 0 where they overlap."""
    ignored = all_but(body, "box", (*LINKS, HELD, "box", TABLE))
    checker = CollisionChecker(KINEMATICS, {"box": box}, held, ignored)
    return checker.nearest(joints, opening_m).distance_m


def random_joints(rng: np.random.Generator) -> Joints:
    return rng.uniform(panda.LOWEST_RAD, panda.HIGHEST_RAD)


def random_box(rng: np.random.Generator, middle: NDArray[np.float64]) -> Cuboid:
    """Turned in any way, within 12 cm of a point in each direction."""
    x, y, z = (float(value) for value in middle + rng.uniform(-0.12, 0.12, 3))
    i, j, k, w = (float(value) for value in rng.normal(size=4))
    length = math.hypot(i, j, k, w)
    a, b, c = (float(value) for value in rng.uniform(0.02, 0.12, 3))
    return Cuboid(Pose((x, y, z), (i / length, j / length, k / length, w / length)), (a, b, c))


def all_but(one: str, other: str, names: tuple[str, ...]) -> list[tuple[str, str]]:
    return [pair for pair in itertools.combinations(names, 2) if {*pair} != {one, other}]


def block_at(x: float, y: float, z: float, edge_m: float = 0.04) -> Cuboid:
    return Cuboid(Pose((x, y, z)), (edge_m, edge_m, edge_m))


def above(x: float, y: float, z: float) -> Joints:
    """With the fingertips there, from above."""
    joints = KINEMATICS.joints(pointing_down(x, y, z, 0.0), panda.READY_RAD)
    assert joints is not None
    return joints


def test_links_are_as_far_from_boxes_as_pybullet_says(other: Other) -> None:
    rng = np.random.default_rng(3)
    names = (*LINKS, "box", TABLE)
    overlapping = 0
    for _ in range(200):
        joints, opening_m = random_joints(rng), float(rng.uniform(0.0, OPEN_M))
        rotation, position = KINEMATICS.links(joints, opening_m)[LINKS[rng.integers(len(LINKS))]]
        box = random_box(rng, position + rotation @ (0.0, 0.0, 0.05))
        other.turn(joints, opening_m)
        body = other.add(box)
        for link in LINKS:
            guard = CollisionChecker(KINEMATICS, {"box": box}, ignored=all_but(link, "box", names))
            found = guard.nearest(joints, opening_m)
            assert found.pair == {link, "box"}
            told_m = other.distance_m(link, body)
            if told_m > 0.002:
                assert told_m - EXACT_M < found.distance_m < told_m + HULL_M + EXACT_M, found
                assert guard.touches(joints, opening_m, found.distance_m - 1e-4) is None
            elif told_m < -0.002:
                assert found.distance_m == 0.0, (link, told_m)
                assert guard.touches(joints, opening_m, 1e-6) == found
                overlapping += 1
        other.remove(body)
    assert overlapping > 100


@pytest.mark.parametrize("body", [*LINKS, HELD])
def test_a_body_is_as_far_from_boxes_as_coal_says(body: str) -> None:
    rng = np.random.default_rng([5, (*LINKS, HELD).index(body)])
    if body == HELD:
        held, shape = IN_HAND, coal.Box(*IN_HAND.edges_m)
        frame, place = panda.HAND_FRAME, IN_HAND.pose
    else:
        held, shape = None, coal_hull(body)
        frame, place = body, Pose((0.0, 0.0, 0.0))
    free = overlapping = 0
    for _ in range(60):
        joints, opening_m = random_joints(rng), float(rng.uniform(0.0, OPEN_M))
        rotation, position = KINEMATICS.links(joints, opening_m)[frame]
        position = rotation @ place.position + position
        rotation = rotation @ place.rotation()
        box = random_box(rng, position)
        witness_m, direction = coal_distance(shape, (rotation, position), box)
        told_m = distance_m(body, box, held, joints, opening_m)
        assert told_m == pytest.approx(max(0.0, witness_m), abs=COAL_M)
        if witness_m > MARGIN_M:
            # Of a box that is a millimetre farther away they say something else.
            x, y, z = (float(value) for value in box.pose.position + 0.001 * direction)
            shifted = Cuboid(Pose((x, y, z), box.pose.orientation), box.edges_m)
            beyond_m = distance_m(body, shifted, held, joints, opening_m) - witness_m
            assert beyond_m == pytest.approx(0.001, abs=COAL_M)
            free += 1
        elif witness_m < 0.0:
            overlapping += 1
    assert free >= 10 and overlapping >= 3


def test_no_distance_is_too_large_where_fcl_stops_early() -> None:
    box = Cuboid(
        Pose((-0.142, -0.173, -0.049), (0.797849, -0.458763, 0.12965, 0.369005)),
        (0.108, 0.054, 0.067),
    )
    assert Body.hull("panda_link6").distance_m(Body.box(box)) < 0.13685
    # Two points, one of each body, are as near as that; FCL alone says 147.9 mm.
    hull = np.array(link_convex_hulls()["panda_link6"].vertices)
    corners = np.array(list(itertools.product(*((-edge / 2, edge / 2) for edge in box.edges_m))))
    corners = corners @ box.pose.rotation().T + box.pose.position
    weights = np.block(
        [[hull.T, -corners.T], [np.repeat([[10.0, 0.0], [0.0, 10.0]], [len(hull), 8], 1)]]
    )
    found, _ = nnls(weights, np.array([0.0, 0.0, 0.0, 10.0, 10.0]))
    of_hull, of_box = found[: len(hull)], found[len(hull) :]
    between = hull.T @ of_hull / of_hull.sum() - corners.T @ of_box / of_box.sum()
    assert np.linalg.norm(between) < 0.13685


def test_links_are_as_far_from_each_other_as_pybullet_says(other: Other) -> None:
    rng = np.random.default_rng(4)
    pairs = [
        pair
        for pair in itertools.combinations(LINKS, 2)
        if frozenset(pair) not in ALLOWED_COLLISIONS
    ]
    free = folded = 0
    for _ in range(200):
        joints, opening_m = random_joints(rng), float(rng.uniform(0.0, OPEN_M))
        other.turn(joints, opening_m)
        told_m = min(other.distance_m(one, other.arm, another) for one, another in pairs)
        found = CollisionChecker(KINEMATICS, {}, ignored=[(link, TABLE) for link in LINKS]).nearest(
            joints, opening_m
        )
        if told_m > 0.002:
            # Here both are rounded off.
            assert told_m - EXACT_M < found.distance_m < told_m + 2 * HULL_M + EXACT_M, found
            free += 1
        elif told_m < -0.002:
            assert found.distance_m == 0.0, (told_m, found)
            folded += 1
    assert free > 20 and folded > 20


def test_the_hand_meets_the_table_where_its_fingertips_are() -> None:
    for height_m in (0.05, 0.01, 0.003):
        found = CollisionChecker(KINEMATICS, {}).nearest(above(0.5, 0.1, height_m), OPEN_M)
        assert TABLE in found.pair and found.pair & {"panda_leftfinger", "panda_rightfinger"}
        assert found.distance_m == pytest.approx(height_m, abs=5e-4)
    touch = CollisionChecker(KINEMATICS, {}).touches(above(0.5, 0.1, -0.005), OPEN_M)
    assert touch is not None and TABLE in touch.pair and touch.distance_m == 0.0


def test_a_message_names_both_and_how_near_they_come() -> None:
    near = CollisionChecker(KINEMATICS, {}).touches(above(0.5, 0.1, 0.001), OPEN_M)
    through = CollisionChecker(KINEMATICS, {}).touches(above(0.5, 0.1, -0.01), OPEN_M)
    assert "finger" in str(near) and TABLE in str(near) and "mm" in str(near)
    assert "finger" in str(through) and "touch" in str(through) and "mm" not in str(through)


def test_what_is_held_is_looked_at_too() -> None:
    joints = above(0.5, 0.0, 0.2)
    in_hand = Cuboid(Pose((0.0, 0.0, panda.FINGERTIP_M)), (0.04, 0.04, 0.04))
    # Below what is held, the block's upper face is 18 cm above the table.
    for gap_m in (0.01, 0.003, 0.001):
        objects = {"block": block_at(0.5, 0.0, 0.18 - gap_m - 0.02)}
        assert CollisionChecker(KINEMATICS, objects).touches(joints, 0.04) is None
        found = CollisionChecker(KINEMATICS, objects, in_hand).nearest(joints, 0.04)
        assert found.pair == {HELD, "block"}
        assert found.distance_m == pytest.approx(gap_m, abs=1e-4)
    hit = CollisionChecker(KINEMATICS, {"block": block_at(0.5, 0.0, 0.17)}, in_hand).touches(
        joints, 0.04
    )
    assert hit is not None and hit.pair == {HELD, "block"} and hit.distance_m == 0.0


def test_what_is_held_turns_with_the_hand() -> None:
    long = Cuboid(Pose.upright(0.0, 0.0, panda.FINGERTIP_M, 0.4), (0.20, 0.03, 0.04))
    joints = above(0.5, 0.0, 0.2)
    held = KINEMATICS.hand(joints) @ long.pose
    end = held.matrix() @ (0.0999, 0.0, 0.0, 1.0)
    x, y, z = (float(value) for value in end[:3])
    hit = CollisionChecker(KINEMATICS, {"end": block_at(x, y, z, 0.002)}, long).nearest(
        joints, 0.03
    )
    assert hit.pair == {HELD, "end"} and hit.distance_m == 0.0
    mirrored = CollisionChecker(KINEMATICS, {"end": block_at(x, -y, z, 0.002)}, long).nearest(
        joints, 0.03
    )
    assert mirrored.distance_m > 0.02


def test_pairs_that_may_touch_are_not_looked_at() -> None:
    joints = above(0.5, 0.0, 0.01)
    objects = {"block": block_at(0.5, 0.04, 0.02)}
    touch = CollisionChecker(KINEMATICS, objects).touches(joints, OPEN_M)
    assert touch is not None and "block" in touch.pair
    (finger,) = touch.pair - {"block"}
    assert (
        CollisionChecker(KINEMATICS, objects, ignored=[("block", finger)]).touches(joints, OPEN_M)
        is None
    )
    assert (
        CollisionChecker(KINEMATICS, objects, ignored=[(finger, TABLE)]).touches(joints, OPEN_M)
        == touch
    )


def test_the_ready_pose_is_free_of_everything() -> None:
    (x0, y0, _), (x1, y1, z1) = WORK_SPACE.min, WORK_SPACE.max
    towers = {
        f"{x} {y}": Cuboid(Pose((x, y, z1 / 2)), (0.06, 0.06, z1))
        for x, y in itertools.product((x0, x1), (y0, 0.0, y1))
    }
    for opening_m in (0.0, OPEN_M):
        for objects in ({}, towers):
            guard = CollisionChecker(KINEMATICS, objects)
            assert guard.nearest(panda.READY_RAD, opening_m).distance_m > 10 * MARGIN_M
            assert guard.touches(panda.READY_RAD, opening_m) is None


def test_along_a_trajectory_the_first_touch_is_told() -> None:
    begin, end = pointing_down(0.5, -0.2, 0.1, 0.0), pointing_down(0.5, 0.2, 0.1, 0.0)
    trajectory = line(KINEMATICS, begin, end, panda.READY_RAD, 1.0)
    assert trajectory is not None
    # Both ends are clear of them.
    thin = {
        name: Cuboid(Pose((0.5, y, 0.07)), (0.04, 0.002, 0.14))
        for name, y in (("first", -0.04), ("second", 0.04))
    }
    guard = CollisionChecker(KINEMATICS, thin)
    ends = (trajectory.begin, trajectory.end)
    assert all(guard.touches(joints, 0.02) is None for joints in ends)
    there, back = guard.along(trajectory, 0.02), guard.along(trajectory.reversed(), 0.02)
    assert there is not None and "first" in there.pair
    assert back is not None and "second" in back.pair
    low = {name: Cuboid(Pose((0.5, 0.0, 0.02)), (0.04, 0.04, 0.04)) for name in thin}
    assert CollisionChecker(KINEMATICS, low).along(trajectory, 0.02) is None


def moving_points(joints: Joints) -> NDArray[np.float64]:
    """All corners of all hulls, and of the largest block in the hand, in the world `[n, 3]`."""
    frames = KINEMATICS.links(joints, OPEN_M)
    points = [
        np.array(hull.vertices) @ frames[link][0].T + frames[link][1]
        for link, hull in link_convex_hulls().items()
    ]
    rotation, position = frames[panda.HAND_FRAME]
    held = np.array(list(itertools.product((-0.03, 0.03), (-0.03, 0.03), (-0.025, 0.025))))
    points.append((held + (0.0, 0.0, panda.FINGERTIP_M)) @ rotation.T + position)
    return np.concatenate(points)


def fast_trajectories() -> list[Trajectory]:
    """At the full pace, stretched far out and near, with one joint and with all."""
    rng = np.random.default_rng(6)
    far = np.array([-1.5, 1.2, 0.0, -0.07, 0.0, 1.9, 0.8])
    near: Along | None = line(
        KINEMATICS,
        pointing_down(0.45, -0.3, 0.2, 0.0),
        pointing_down(0.45, 0.3, 0.2, 0.0),
        panda.READY_RAD,
        1.0,
    )
    assert near is not None
    return [
        Straight(far, far + (3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
        Straight(far, far + (3.0, 0.4, 0.3, -0.4, 0.3, 0.3, 0.3)),
        Straight(panda.READY_RAD, random_joints(rng)),
        near,
    ]


def away_m(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(one - other, axis=1).max())


@pytest.mark.parametrize("margin_m", [MARGIN_M, 0.01])
def test_no_point_gets_farther_than_the_margin_from_where_it_was_looked_at(
    margin_m: float,
) -> None:
    for trajectory in fast_trajectories():
        looked = [moving_points(joints) for joints in steps(trajectory, margin_m).joints]
        assert away_m(looked[0], moving_points(trajectory.begin)) < 1e-5
        assert away_m(looked[-1], moving_points(trajectory.end)) < 1e-5
        for one, following in itertools.pairwise(looked):
            assert away_m(one, following) <= 2 * margin_m
        # Each moment in between is near to the look before it or to the next.
        at = 0
        for joints in trajectory.at(np.linspace(0.0, trajectory.duration_s, 1500)).joints:
            points = moving_points(joints)
            nearest_m = away_m(points, looked[at])
            while at + 1 < len(looked):
                next_m = away_m(points, looked[at + 1])
                if next_m > nearest_m:
                    break
                at, nearest_m = at + 1, next_m
            assert nearest_m <= margin_m


def test_an_arm_that_stays_is_looked_at_where_it_is() -> None:
    looked = steps(Straight(panda.READY_RAD, panda.READY_RAD), MARGIN_M).joints
    assert len(looked) > 0
    np.testing.assert_allclose(looked, np.tile(panda.READY_RAD, (len(looked), 1)))


class Watched(CollisionChecker):
    """Keeps what was looked at, and how far it may move from there."""

    looked: list[tuple[Joints, float]]

    def free_m(
        self, joints: Joints, opening_m: float, known_m: NDArray[np.float64] | None = None
    ) -> float:
        free_m = super().free_m(joints, opening_m, known_m)
        self.looked.append((joints, free_m))
        return free_m


@pytest.mark.slow
def test_only_steps_are_left_out_in_which_nothing_can_have_come_near() -> None:
    rng = np.random.default_rng(11)
    touched = stepped = looked = 0
    for number in range(12):
        blocks = {
            f"block {index}": Cuboid(Pose.upright(x, y, z, angle), (0.08, 0.08, 0.08))
            for index, (x, y, z, angle) in enumerate(
                rng.uniform((0.3, -0.4, 0.1, 0.0), (0.7, 0.4, 0.7, 3.0), (5, 4))
            )
        }
        held = Cuboid(Pose((0.0, 0.0, 0.1)), (0.04, 0.04, 0.06)) if number % 2 else None
        guard = Watched(KINEMATICS, blocks, held)
        guard.looked = []
        trajectory = Straight(
            panda.READY_RAD + rng.normal(0, 0.4, panda.JOINTS),
            panda.READY_RAD + rng.normal(0, 0.4, panda.JOINTS),
        )
        every = steps(trajectory, MARGIN_M)
        touches = [guard.touches(joints, OPEN_M) for joints in every.joints]
        first = next((touch for touch in touches if touch is not None), None)
        assert guard.along(trajectory, OPEN_M) == first
        at = [int(np.flatnonzero((every.joints == it).all(axis=1))[0]) for it, _ in guard.looked]
        free_m = [free_m for _, free_m in guard.looked]
        for one, following, far_m in zip(at, at[1:], free_m, strict=False):
            assert following == one + 1 or (
                every.moved_m[following - 1] < every.moved_m[one] + far_m
            )
        end = len(touches) if first is None else touches.index(first) + 1
        assert first is not None or every.moved_m[-1] <= every.moved_m[at[-1]] + free_m[-1]
        touched, stepped, looked = touched + (first is not None), stepped + end, looked + len(at)
        for joints, far_m in guard.looked[::20]:
            nearest_m = guard.nearest(joints, OPEN_M).distance_m - MARGIN_M
            assert (far_m > 0) == (nearest_m > 0)
            if far_m > 0:
                assert min(nearest_m / 2, FAR_M) - 1e-6 <= far_m <= min(nearest_m, FAR_M) + 1e-6
    assert 3 <= touched <= 9
    assert looked < 0.7 * stepped


class Rounded(CollisionChecker):
    """Tells distances in tenths of a millimetre."""

    def _distance_m(self, i: int, j: int) -> float:
        return round(super()._distance_m(i, j), 4)


def test_behind_a_place_that_is_as_near_as_the_margin_it_is_looked_at_too() -> None:
    in_hand = Cuboid(Pose((0.0, 0.0, panda.FINGERTIP_M)), (0.04, 0.04, 0.04))
    begin, end = (pointing_down(0.5, y, 0.12, 0.0) for y in (-0.15, 0.15))
    trajectory = line(KINEMATICS, begin, end, panda.READY_RAD, 1.0)
    assert trajectory is not None
    # What is held is as near to the first as the margin at the beginning, and hits the second.
    objects = {"first": block_at(0.5, -0.15, 0.08 - MARGIN_M), "second": block_at(0.5, 0.1, 0.12)}
    guard = Rounded(KINEMATICS, objects, in_hand)
    assert guard.free_m(trajectory.begin, 0.04) == 0.0
    assert guard.touches(trajectory.begin, 0.04) is None
    touch = guard.along(trajectory, 0.04)
    assert touch is not None and "second" in touch.pair
    # And it is free if nothing but that is near.
    del objects["second"]
    assert Rounded(KINEMATICS, objects, in_hand).along(trajectory, 0.04) is None


def test_two_that_move_are_near_after_half_the_way() -> None:
    # The hand turns towards the arm itself: nothing stands there.
    guard = CollisionChecker(KINEMATICS, {})
    folded = panda.READY_RAD + np.array([0.0, 0.0, 0.0, -0.3, 0.0, -1.2, 0.0])
    nearest = guard.nearest(folded, OPEN_M)
    assert TABLE not in nearest.pair and MARGIN_M < nearest.distance_m < 2 * FAR_M
    assert guard.free_m(folded, OPEN_M) == pytest.approx((nearest.distance_m - MARGIN_M) / 2)


def test_no_point_is_farther_from_a_joint_than_its_reach() -> None:
    """The way of a point by a small turn of one joint alone."""
    rng = np.random.default_rng(7)
    turn_rad = 1e-4
    farthest = np.zeros(panda.JOINTS)
    # Stretched out at first, then anyhow.
    poses = [np.array([0.0, 1.2, 0.0, -0.07, 0.0, 1.9, 0.8])]
    poses += [random_joints(rng) for _ in range(300)]
    for joints in poses:
        points = moving_points(joints)
        for joint in range(panda.JOINTS):
            turned = joints.copy()
            turned[joint] += turn_rad
            moved_m = np.linalg.norm(moving_points(turned) - points, axis=1).max()
            farthest[joint] = max(farthest[joint], moved_m / turn_rad)
    assert (farthest <= REACH_M).all(), farthest
    # It was indeed stretched out.
    assert (farthest[:3] > 0.8 * REACH_M[:3]).all(), farthest
