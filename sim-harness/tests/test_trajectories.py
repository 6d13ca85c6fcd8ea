"""Where the arm's hand is, how it gets there, and how long it takes."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation import paths
from nsrm_harness.manipulation.grasps import LEANS_RAD, pointing_down
from nsrm_harness.manipulation.kinematics import LIMIT_MARGIN_RAD, Joints, Kinematics
from nsrm_harness.manipulation.trajectory import (
    Along,
    Straight,
    Trajectory,
    moments_of,
    rest_to_rest,
)
from nsrm_harness.simulation.arm import rest_links

KINEMATICS = Kinematics()
TICK_S = 2e-4


def lifted(x: float, y: float, yaw_rad: float, near: Joints, pace: float = 1.0) -> Along:
    """A line of the hand, straight up."""
    low, high = (pointing_down(x, y, z, yaw_rad) for z in (0.02, 0.12))
    found = paths.line(KINEMATICS, low, high, near, pace)
    assert found is not None, (x, y, yaw_rad)
    return found


def within_limits(trajectory: Trajectory, begin: Joints, end: Joints) -> None:
    """Looks at it every fifth of a millisecond, by differences of its angles alone."""
    moments = trajectory.at(np.arange(0.0, trajectory.duration_s + TICK_S, TICK_S))
    assert moments.joints.shape == moments.speeds.shape == moments.accelerations.shape
    assert moments.joints.shape[1] == panda.JOINTS
    for given, first_or_last, row in ((begin, trajectory.begin, 0), (end, trajectory.end, -1)):
        np.testing.assert_allclose(first_or_last, given, atol=1e-12)
        np.testing.assert_allclose(moments.joints[row], given, atol=1e-12)
        np.testing.assert_allclose(moments.speeds[row], 0.0, atol=1e-4)
    speeds = np.diff(moments.joints, axis=0) / TICK_S
    told = moments.speeds
    np.testing.assert_allclose(speeds, (told[1:] + told[:-1]) / 2, atol=1e-4)
    accelerations = np.diff(told, axis=0) / TICK_S
    np.testing.assert_allclose(
        accelerations, (moments.accelerations[1:] + moments.accelerations[:-1]) / 2, atol=0.5
    )
    jerks = np.diff(moments.accelerations, axis=0) / TICK_S
    for values, limit in (
        (speeds, panda.MAX_SPEED_RAD_S),
        (accelerations, panda.MAX_ACCELERATION_RAD_S2),
        (jerks, panda.MAX_JERK_RAD_S3),
    ):
        assert (np.abs(values) <= limit * 1.001).all()


def test_the_hand_is_where_the_simulator_has_it() -> None:
    links = dict(rest_links())
    hand = KINEMATICS.hand(np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]))
    assert hand.distance_m(links[panda.HAND_FRAME]) < 1e-6
    assert hand.angle_rad(links[panda.HAND_FRAME]) < 1e-6


def test_all_of_the_work_space_is_reached_from_above() -> None:
    xs, ys = np.linspace(0.35, 0.65, 4), np.linspace(-0.25, 0.25, 5)
    yaws = np.linspace(-math.pi / 4, math.pi / 4, 3)
    for x, y, z, yaw in itertools.product(xs, ys, (0.01, 0.1, 0.2, 0.3), yaws):
        hand = pointing_down(x, y, z, yaw)
        joints = KINEMATICS.joints(hand, panda.READY_RAD)
        assert joints is not None, (x, y, z, yaw)
        assert (joints >= panda.LOWEST_RAD).all() and (joints <= panda.HIGHEST_RAD).all()
        reached = KINEMATICS.hand(joints)
        assert reached.distance_m(hand) < 2e-5 and reached.angle_rad(hand) < 2e-4


def downward(count: int, most_rad: float) -> list[Joints]:
    """Joints drawn from within the maker's limits that have the hand point down, or lean by so much
    at most."""
    rng = np.random.default_rng(0)
    inside_rad = 0.1
    found: list[Joints] = []
    while len(found) < count:
        joints = rng.uniform(panda.LOWEST_RAD + inside_rad, panda.HIGHEST_RAD - inside_rad)
        if -KINEMATICS.hand(joints).rotation()[2, 2] >= math.cos(most_rad):
            found.append(joints)
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("leans_rad", "most_refused"), [(0.05, 0.1), (max(LEANS_RAD), 0.02)], ids=["upright", "leaning"]
)
def test_where_joints_have_brought_the_hand_joints_are_found(
    leans_rad: float, most_refused: float
) -> None:
    poses = downward(150, leans_rad)
    refused = 0
    for own in poses:
        hand = KINEMATICS.hand(own)
        for near in (own, panda.READY_RAD):
            joints = KINEMATICS.joints(hand, near)
            if joints is None:
                # Anywhere, also behind the arm: from the ready pose not all of it is found.
                assert near is panda.READY_RAD, own
                refused += 1
                continue
            assert (joints > panda.LOWEST_RAD).all() and (joints < panda.HIGHEST_RAD).all()
            reached = KINEMATICS.hand(joints)
            assert reached.distance_m(hand) < 2e-5 and reached.angle_rad(hand) < 2e-4
    assert refused <= most_refused * len(poses)


def test_the_elbow_is_as_near_to_the_ready_pose_as_the_hand_allows() -> None:
    hand = pointing_down(0.5, 0.1, 0.1, 0.3)
    near = panda.READY_RAD + np.array([0.6, 0.0, -0.6, 0.0, 0.4, 0.0, 0.0])
    one, other = (KINEMATICS.joints(hand, each) for each in (panda.READY_RAD, near))
    assert one is not None and other is not None
    # From wherever it is looked for.
    np.testing.assert_allclose(one, other, atol=2e-3)


@pytest.mark.slow
def test_lines_keep_within_the_makers_limits_where_places_of_them_are_at_the_limits() -> None:
    at_limits = 0
    for own in downward(400, max(LEANS_RAD)):
        hand = KINEMATICS.hand(own)
        x, y, z = hand.position
        above = replace(hand, position=(x, y, z + 0.08))
        along = paths.line(KINEMATICS, hand, above, own, 1.0)
        if along is None:
            continue
        joints = along.at(np.linspace(0.0, along.duration_s, 500)).joints
        inside_rad = np.minimum(joints - panda.LOWEST_RAD, panda.HIGHEST_RAD - joints).min()
        assert inside_rad > 0.0, own
        at_limits += inside_rad < 1.1 * LIMIT_MARGIN_RAD
    assert at_limits


@pytest.mark.parametrize("x", [0.0, 1.2])
def test_what_is_out_of_reach_has_no_joints(x: float) -> None:
    assert KINEMATICS.joints(pointing_down(x, 0.0, 0.1, 0.0), panda.READY_RAD) is None


def test_where_joints_can_bring_the_hand_it_may_reach() -> None:
    rng = np.random.default_rng(0)
    for joints in rng.uniform(panda.LOWEST_RAD, panda.HIGHEST_RAD, (5000, panda.JOINTS)):
        # Upper arm and forearm on one line.
        joints[3] = rng.choice([joints[3], -0.467])
        assert KINEMATICS.may_reach(KINEMATICS.hand(joints)), joints


def test_beyond_the_stretched_arm_it_may_not() -> None:
    # With the wrist as high as the shoulder: 0.3266 and 0.3928 m of arm, and 0.088 m to the
    # axis of the hand.
    hand = pointing_down(0.0, 0.0, 0.333 - 0.107 - panda.FINGERTIP_M, 0.3)
    for turned in np.linspace(-3, 3, 7):
        place = np.array([math.cos(turned), math.sin(turned), 0.0]) + hand.position
        for far_m, may in ((0.8073, True), (0.8076, False)):
            x, y, _ = far_m * place
            there = replace(hand, position=(float(x), float(y), hand.position[2]))
            assert KINEMATICS.may_reach(there) is may, (turned, far_m)
            assert may or KINEMATICS.joints(there, panda.READY_RAD) is None


def test_what_was_asked_before_changes_no_answer() -> None:
    hands = [pointing_down(0.5, y, 0.1, 0.0) for y in (-0.1, 0.1)]
    used, again = Kinematics(), Kinematics()
    for hand in hands:
        used.joints(hand, panda.READY_RAD)
    for hand in reversed(hands):
        one, other = (each.joints(hand, panda.READY_RAD) for each in (used, again))
        assert one is not None and other is not None
        np.testing.assert_array_equal(one, other)
        # Else who asks next would get what this one has made of it.
        with pytest.raises(ValueError, match="read-only"):
            one[0] = 0.0


def test_moves_keep_within_the_makers_limits_and_lines_are_straight() -> None:
    rng = np.random.default_rng(1)
    joints = panda.READY_RAD
    for _ in range(4):
        x, y, yaw = rng.uniform((0.35, -0.25, -1.5), (0.65, 0.25, 1.5))
        along = lifted(x, y, yaw, joints)
        within_limits(Straight(joints, along.begin), joints, along.begin)
        within_limits(along, along.begin, along.end)
        for reached in along.at(np.linspace(0.0, along.duration_s, 40)).joints:
            hand = KINEMATICS.hand(reached)
            assert math.dist(hand.position[:2], (x, y)) < 1e-4
            assert hand.angle_rad(pointing_down(x, y, 0.0, yaw)) < 5e-4
        joints = along.end


def test_a_line_that_can_not_be_followed_is_none() -> None:
    def along_y(x: float, yaw_rad: float) -> Along | None:
        left, right = (pointing_down(x, y, 0.1, yaw_rad) for y in (0.45, -0.45))
        assert KINEMATICS.joints(left, panda.READY_RAD) is not None
        return paths.line(KINEMATICS, left, right, panda.READY_RAD, 1.0)

    def leads_out() -> Along | None:
        ends = pointing_down(0.5, 0.0, 0.1, 0.0), pointing_down(1.2, 0.0, 0.1, 0.0)
        return paths.line(KINEMATICS, *ends, panda.READY_RAD, 1.0)

    assert along_y(0.45, 0.0) is not None
    assert leads_out() is None
    # Too near to the base in the middle.
    assert along_y(0.1, 0.0) is None


def test_a_line_on_which_the_arm_would_fold_over_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    begin, end = (pointing_down(0.45, y, 0.1, -3.0) for y in (0.45, -0.45))
    assert paths.line(KINEMATICS, begin, end, panda.READY_RAD, 1.0) is None
    # All of its places can be reached.
    monkeypatch.setattr(paths, "MAX_OFF_RAD", math.inf)
    assert paths.line(KINEMATICS, begin, end, panda.READY_RAD, 1.0) is not None


def test_a_line_on_which_the_elbow_swings_aside_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    x, y, z = 0.4653, 0.1689, 0.1319
    leans = (0.696307, 0.696307, 0.123112, -0.123112)
    near = np.array([-0.605, 0.6585, 0.3077, -1.7313, 0.2081, 2.2861, -1.124])
    ends = Pose((x, y, z), leans), Pose((x, y, z + 0.08), leans)
    assert paths.line(KINEMATICS, *ends, near, 1.0) is None
    # No two of these are far from each other, but no smooth way leads through all.
    monkeypatch.setattr(paths, "MAX_OFF_RAD", math.inf)
    found = paths.line(KINEMATICS, *ends, near, 1.0)
    assert found is not None and found.off_rad > 0.01


def test_a_way_along_joints_begins_and_ends_with_them_and_tells_how_near_it_is() -> None:
    bent = [
        panda.READY_RAD + turn for turn in (0.0, 0.05, 0.3, 0.32, 0.31, 0.4, 0.41, 0.4, 0.5, 0.6)
    ]
    trajectory = Along(bent)
    reached = trajectory.at(np.array([0.0, trajectory.duration_s])).joints
    np.testing.assert_allclose(reached, [bent[0], bent[-1]], atol=1e-12)
    assert 0.005 < trajectory.off_rad < 0.1
    even = [panda.READY_RAD + turn for turn in np.linspace(0.0, 0.5, 10)]
    assert Along(even).off_rad < 1e-12


def test_before_it_begins_and_after_it_ends_a_trajectory_is_at_its_ends() -> None:
    for trajectory in (
        Straight(panda.READY_RAD, panda.READY_RAD + 0.5),
        lifted(0.5, 0.0, 0.0, panda.READY_RAD),
    ):
        moments = trajectory.at(np.array([-1.0, trajectory.duration_s + 1.0]))
        np.testing.assert_allclose(moments.joints, [trajectory.begin, trajectory.end], atol=1e-12)
        np.testing.assert_allclose(moments.speeds, 0.0, atol=1e-9)


def test_a_straight_move_turns_all_joints_in_one_proportion() -> None:
    rng = np.random.default_rng(2)
    for _ in range(5):
        begin, end = rng.uniform(panda.LOWEST_RAD, panda.HIGHEST_RAD, (2, panda.JOINTS))
        straight = Straight(begin, end)
        moments = straight.at(np.linspace(0.0, straight.duration_s, 200))
        shares = (moments.joints - begin) / (end - begin)
        np.testing.assert_allclose(shares, shares[:, :1].repeat(panda.JOINTS, axis=1), atol=1e-6)
        assert (np.diff(shares[:, 0]) > 0).all()
        assert 0.2 < shares[100, 0] < 0.8


@pytest.mark.parametrize("pace", [1.0, 0.3])
def test_the_way_back_is_the_same_way(pace: float) -> None:
    trajectories: tuple[Trajectory, ...] = (
        Straight(panda.READY_RAD, panda.READY_RAD + np.linspace(-0.5, 0.7, panda.JOINTS), pace),
        lifted(0.42, 0.17, 0.6, panda.READY_RAD, pace),
    )
    for trajectory in trajectories:
        is_line = isinstance(trajectory, Along)
        reverse = Straight(trajectory.end, trajectory.begin, pace)
        back = trajectory.reversed() if is_line else reverse
        assert back.duration_s == pytest.approx(trajectory.duration_s)
        np.testing.assert_array_equal(back.begin, trajectory.end)
        np.testing.assert_array_equal(back.end, trajectory.begin)
        times = np.linspace(0.0, trajectory.duration_s, 100)
        there, again = trajectory.at(times), back.at(trajectory.duration_s - times)
        np.testing.assert_allclose(again.joints, there.joints, atol=1e-6)
        np.testing.assert_allclose(again.speeds, -there.speeds, atol=1e-5)


def test_a_slower_pace_takes_longer() -> None:
    end = panda.READY_RAD + 0.5
    assert (
        Straight(panda.READY_RAD, end, 0.5).duration_s > Straight(panda.READY_RAD, end).duration_s
    )


def test_moments_are_those_of_ruckig() -> None:
    rng = np.random.default_rng(4)
    for limits in np.exp(rng.uniform([-2.0, 0.0, 2.0], [2.0, 3.0, 6.0], (200, 3))):
        timed = rest_to_rest(*limits)
        times_s = np.array([0.0, *rng.uniform(0.0, timed.duration, 20), timed.duration])
        expected = np.array([timed.at_time(time_s) for time_s in times_s.tolist()])[..., 0]
        # Before and behind it, too.
        for outside in (np.array([-1.0]), np.array([2 * timed.duration])):
            found = np.hstack(moments_of(timed, np.concatenate([times_s, outside])))
            at = 0 if outside[0] < 0 else -1
            np.testing.assert_allclose(found[:-1], expected, atol=1e-12)
            np.testing.assert_allclose(found[-1], expected[at], atol=1e-12)
