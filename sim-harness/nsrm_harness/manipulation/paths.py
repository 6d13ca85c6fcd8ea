"""Ways of the arm that touch nothing: a line of the hand, a straight move of the joints, or
where that would touch something, moves that a sampling planner finds."""

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
"""Of a line, at which the joints are solved for."""
MAX_OFF_RAD = 1e-3
"""Of a joint from where a place of a line has it: no smooth motion leads through places between
which the arm folds over, or its elbow swings aside."""
RANGE_RAD = 0.6
"""The longest move that the planner tries at once (sum over joints, as the root of squares)."""
TURN_S = 0.05
"""So often it is looked at how far the hand has turned: no joint turns by 0.14 rad in it."""
MAX_LOOKS = 4000
"""Of the planner at its own stopping condition: it ends by counting, not by time."""
SEED = 1

ompl.setLogLevel(ompl.LogLevel.LOG_NONE)


def line(kinematics: Kinematics, begin: Pose, end: Pose, near: Joints, pace: float) -> Along | None:
    """The hand on a straight line, not turning; None where the arm can't follow.

    * `near`: joints that the first ones are to be near to
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


def turned_rad(kinematics: Kinematics, ways: Sequence[Trajectory]) -> float:
    """How far the hand turns about the vertical on its way: between the two moments that are the
    farthest apart, whole turns included."""
    yaws_rad = [
        kinematics.hand(joints).yaw_rad()
        for way in ways
        for joints in way.at(np.arange(0.0, way.duration_s + TURN_S, TURN_S)).joints
    ]
    return float(np.ptp(np.unwrap(yaws_rad)))


def free(
    guard: CollisionChecker, begin: Joints, end: Joints, opening_m: float, pace: float
) -> list[Trajectory] | Nearest:
    """Moves from here to there that touch nothing; what the straight one touches if none is
    found. The same ones each time."""
    straight = Straight(begin, end, pace)
    touch = guard.along(straight, opening_m)
    if touch is None:
        return [straight]
    for joints in (begin, end):
        at = guard.touches(joints, opening_m)
        if at is not None:
            return at
    found: list[Trajectory] = []
    places = _sampled(guard, begin, end, opening_m)
    for one, other in itertools.pairwise(places):
        move = Straight(one, other, pace)
        if guard.along(move, opening_m) is not None:
            return touch
        found.append(move)
    return found or touch


def _sampled(guard: CollisionChecker, begin: Joints, end: Joints, opening_m: float) -> list[Joints]:
    """Places of a free way, by RRT-Connect (Kuffner and LaValle, 2000); empty if none was found
    in a bounded number of steps."""
    # Otherwise it would depend on what was planned before.
    ompl.RNG.setSeed(SEED)
    space = base.RealVectorStateSpace(panda.JOINTS)
    bounds = base.RealVectorBounds(panda.JOINTS)
    for joint in range(panda.JOINTS):
        bounds.setLow(joint, float(panda.LOWEST_RAD[joint]))
        bounds.setHigh(joint, float(panda.HIGHEST_RAD[joint]))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(
        lambda state: guard.touches(_joints(state), opening_m, 1.5 * MARGIN_M) is None
    )
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(0.01 / space.getMaximumExtent())
    planner = geometric.RRTConnect(information)
    planner.setRange(RANGE_RAD)
    setup.setPlanner(planner)
    # The types that ompl comes with don't know its states' values.
    states: list[Any] = [space.allocState(), space.allocState()]
    for state, joints in zip(states, (begin, end), strict=True):
        for joint in range(panda.JOINTS):
            state[joint] = float(joints[joint])
    setup.setStartAndGoalStates(*states)
    looks = 0

    def enough() -> bool:
        nonlocal looks
        looks += 1
        return looks > MAX_LOOKS

    setup.solve(base.PlannerTerminationCondition(enough))
    if not setup.haveExactSolutionPath():
        return []
    path = setup.getSolutionPath()
    geometric.PathSimplifier(information).reduceVertices(path)
    return [_joints(path.getState(index)) for index in range(path.getStateCount())]


def _joints(state: Any) -> Joints:
    return np.array([state[joint] for joint in range(panda.JOINTS)])
