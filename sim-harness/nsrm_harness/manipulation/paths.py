"""Collision-free paths of the arm: straight lines of the hand, and joint moves, which are straight
where free and otherwise found by a sampling-based planner."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from ompl import base, geometric
from ompl import util as ompl

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.collision import MARGIN_M, CollisionChecker, Nearest
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.manipulation.trajectory import Along, Straight, Trajectory

PLACES = 15
"""Number of waypoints of a line for which the joints are solved."""
MAX_OFF_RAD = 1e-3
"""Maximum deviation of a joint from a waypoint of a line: no smooth motion passes through waypoints
between which the arm folds over or its elbow swings aside."""
RANGE_RAD = 0.6
"""The planner's longest single move (Euclidean norm over the joints)."""
TURN_S = 0.05
"""Sampling interval for the hand's rotation: no joint turns by more than 0.14 rad within it."""
MAX_CHECKS = 4000
"""How often the planner may evaluate its termination condition: it ends by a count, not by time."""
SEED = 1

ompl.setLogLevel(ompl.LogLevel.LOG_NONE)


def line(kinematics: Kinematics, begin: Pose, end: Pose, near: Joints, pace: float) -> Along | None:
    """Moves the hand along a straight line without rotating it; None if the arm cannot follow.

    * `near`: initial guess for the first waypoint's joints
    """
    found: list[Joints] = []
    for share in np.linspace(0.0, 1.0, PLACES):
        x, y, z = (
            float((1 - share) * a + share * b)
            for a, b in zip(begin.position, end.position, strict=True)
        )
        joints = kinematics.joints(Pose((x, y, z), begin.orientation), found[-1] if found else near)
        if joints is None:
            return None
        found.append(joints)
    along = Along(found, pace)
    return along if along.off_rad <= MAX_OFF_RAD else None


def turned_rad(kinematics: Kinematics, path: Sequence[Trajectory]) -> float:
    """How far the hand rotates about the vertical along its path: between the two moments that are
    the farthest apart, full turns included."""
    yaws_rad = [
        kinematics.hand(joints).yaw_rad()
        for segment in path
        for joints in segment.at(np.arange(0.0, segment.duration_s + TURN_S, TURN_S)).joints
    ]
    return float(np.ptp(np.unwrap(yaws_rad)))


def free(
    checker: CollisionChecker, begin: Joints, end: Joints, opening_m: float, pace: float
) -> list[Trajectory] | Nearest:
    """A collision-free path between two configurations: the straight move of the joints, or else
    moves that a sampling-based planner finds. If there is none, what the straight move touches, or
    what `begin` or `end` does. Deterministic."""
    straight = Straight(begin, end, pace)
    touch = checker.along(straight, opening_m)
    if touch is None:
        return [straight]
    for joints in (begin, end):
        at = checker.touches(joints, opening_m)
        if at is not None:
            return at
    found: list[Trajectory] = []
    places = _sampled(checker, begin, end, opening_m)
    for one, other in itertools.pairwise(places):
        move = Straight(one, other, pace)
        if checker.along(move, opening_m) is not None:
            return touch
        found.append(move)
    return found or touch


def _sampled(
    checker: CollisionChecker, begin: Joints, end: Joints, opening_m: float
) -> list[Joints]:
    """The waypoints of a free path, by RRT-Connect (Kuffner and LaValle, 2000); empty if none was
    found in a bounded number of steps."""
    # Without this, the result would depend on what was planned before.
    ompl.RNG.setSeed(SEED)
    space = base.RealVectorStateSpace(panda.JOINTS)
    bounds = base.RealVectorBounds(panda.JOINTS)
    for joint in range(panda.JOINTS):
        bounds.setLow(joint, float(panda.LOWEST_RAD[joint]))
        bounds.setHigh(joint, float(panda.HIGHEST_RAD[joint]))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(
        lambda state: checker.touches(_joints(state), opening_m, 1.5 * MARGIN_M) is None
    )
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(0.01 / space.getMaximumExtent())
    planner = geometric.RRTConnect(information)
    planner.setRange(RANGE_RAD)
    setup.setPlanner(planner)
    # OMPL's type stubs lack the values of its states.
    states: list[Any] = [space.allocState(), space.allocState()]
    for state, joints in zip(states, (begin, end), strict=True):
        for joint in range(panda.JOINTS):
            state[joint] = float(joints[joint])
    setup.setStartAndGoalStates(*states)
    checks = 0

    def enough() -> bool:
        nonlocal checks
        checks += 1
        return checks > MAX_CHECKS

    setup.solve(base.PlannerTerminationCondition(enough))
    if not setup.haveExactSolutionPath():
        return []
    path = setup.getSolutionPath()
    geometric.PathSimplifier(information).reduceVertices(path)
    return [_joints(path.getState(index)) for index in range(path.getStateCount())]


def _joints(state: Any) -> Joints:
    return np.array([state[joint] for joint in range(panda.JOINTS)])
