"""Where a block can stand, and where it cannot."""

from __future__ import annotations

import math

import pytest

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.stability import (
    CENTRED_M,
    LEVEL_M,
    ROOM_M,
    STABLE_M,
    TABLE,
    TOUCH_M,
    placement,
    resting_on,
    standing_on,
)

EDGE_M = 0.04
CUBE: Vector3 = (EDGE_M, EDGE_M, EDGE_M)
MM = 0.001
X = 0.5


def cube(x: float, y: float = 0.0, foot: float = 0.0, edges: Vector3 = CUBE) -> Cuboid:
    """Its foot at that height."""
    return Cuboid(Pose((x, y, foot + edges[2] / 2)), edges)


BLOCK = cube(0.4, 0.2)
BASE = cube(X)


def refusal(goal: Cuboid, **others: Cuboid) -> RefusedError:
    with pytest.raises(RefusedError) as caught:
        placement(goal.pose, goal, others)
    return caught.value


@pytest.mark.parametrize("off_m", [-LEVEL_M + MM, -0.004, 0.004, LEVEL_M - MM])
def test_a_sub_goal_that_is_a_little_too_high_or_low_is_put_right(off_m: float) -> None:
    onto = placement(Pose((X, 0.0, 1.5 * EDGE_M + off_m)), BLOCK, {"base": BASE})
    assert onto.cuboid.bottom_m == pytest.approx(BASE.top_m)
    assert onto.support == ("base",)
    assert onto.corrected_m == pytest.approx(abs(off_m))
    beside = placement(Pose((X, 0.2, EDGE_M / 2 + off_m)), BLOCK, {"base": BASE})
    assert beside.cuboid.bottom_m == pytest.approx(0.0)
    assert beside.cuboid.pose.position[:2] == (X, 0.2)
    assert beside.support == (TABLE,)
    assert beside.corrected_m == pytest.approx(abs(off_m))


@pytest.mark.parametrize("off_m", [-LEVEL_M - MM, LEVEL_M + MM])
def test_one_that_is_too_high_or_low_by_more_has_no_support(off_m: float) -> None:
    for base, foot_m in ((BASE, EDGE_M), (cube(X, 0.3), 0.0)):
        refused = refusal(cube(X, 0.0, foot_m + off_m), base=base)
        assert refused.why is RefusalReason.NO_SUPPORT
        assert f"{1000 * abs(foot_m + off_m):.0f} mm" in str(refused)
        assert ("below" in str(refused)) == (foot_m + off_m < 0)


def test_on_one_block_it_is_centred_if_it_is_nearly() -> None:
    turn = Pose.upright(X, 0.0, 0.0, 0.4).orientation
    base = Cuboid(Pose((X, 0.1, EDGE_M / 2)), (0.06, 0.06, EDGE_M))
    for off_m in (0.004, CENTRED_M - MM):
        goal = Pose((X - 0.6 * off_m, 0.1 + 0.8 * off_m, 1.5 * EDGE_M), turn)
        put = placement(goal, BLOCK, {"base": base})
        assert put.cuboid.pose.position == pytest.approx((X, 0.1, 1.5 * EDGE_M))
        assert put.cuboid.pose.orientation == turn
        assert put.corrected_m == pytest.approx(off_m)
    goal = Pose((X, 0.1 + CENTRED_M + MM, 1.5 * EDGE_M))
    put = placement(goal, BLOCK, {"base": base})
    assert put.cuboid.pose.position == pytest.approx(goal.position)
    assert put.corrected_m == pytest.approx(0.0)


def test_the_block_keeps_its_edges() -> None:
    long = Cuboid(Pose((0.4, 0.2, 0.015)), (0.08, 0.02, 0.03))
    put = placement(Pose((X, 0.0, EDGE_M + 0.02)), long, {"base": BASE})
    assert put.cuboid.edges_m == long.edges_m
    assert put.cuboid.bottom_m == pytest.approx(BASE.top_m)


@pytest.mark.parametrize(("x", "y"), [(EDGE_M, 0.0), (-EDGE_M, 0.0), (0.0, EDGE_M)])
def test_a_neighbour_that_is_too_near_is_named(x: float, y: float) -> None:
    def beside(gap_m: float) -> Cuboid:
        share = 1 + gap_m / EDGE_M
        return cube(X + share * x, share * y)

    refused = refusal(beside(ROOM_M - MM), far=cube(X, -0.2), base=BASE)
    assert refused.why is RefusalReason.NO_ROOM
    assert "base" in str(refused) and "far" not in str(refused)
    put = placement(beside(ROOM_M + MM).pose, BLOCK, {"base": BASE})
    assert put.support == (TABLE,)


def test_a_turned_neighbour_is_near_by_its_corner() -> None:
    turned = Cuboid(Pose.upright(X, 0.0, EDGE_M / 2, math.pi / 4), CUBE)
    # A corner reaches 8.3 mm farther out than a face would.
    gap_m = 0.008
    goal = cube(X + EDGE_M + gap_m)
    assert refusal(goal, turned=turned).why is RefusalReason.NO_ROOM
    assert placement(goal.pose, BLOCK, {"straight": BASE}).support == (TABLE,)


def test_a_tower_is_in_the_way_of_what_is_put_beside_its_top_and_a_low_block_is_not() -> None:
    goal = cube(X, 0.0, EDGE_M)
    beside_m = X + EDGE_M + 0.001
    lower = cube(beside_m, edges=(EDGE_M, EDGE_M, 0.03))
    assert placement(goal.pose, BLOCK, {"base": BASE, "lower": lower}).support == ("base",)
    refused = refusal(goal, base=BASE, lower=lower, upper=cube(beside_m, 0.0, 0.03))
    assert refused.why is RefusalReason.NO_ROOM
    assert "upper" in str(refused) and "lower" not in str(refused)


def test_there_is_no_room_within_another_block() -> None:
    refused = refusal(cube(X + 0.01), base=BASE)
    assert refused.why is RefusalReason.NO_ROOM and "base" in str(refused)


def test_what_hangs_over_too_far_would_fall() -> None:
    half_m = EDGE_M / 2
    for off_m in (half_m - STABLE_M + MM, half_m + 0.005):
        refused = refusal(cube(X, -off_m, EDGE_M), base=BASE)
        assert refused.why is RefusalReason.UNSTABLE
        assert "base" in str(refused) and "tower" not in str(refused)
    goal = cube(X, -(half_m - STABLE_M - MM), EDGE_M)
    assert placement(goal.pose, BLOCK, {"base": BASE}).cuboid.pose == goal.pose


def test_a_tower_falls_that_leans_though_each_block_alone_would_stand() -> None:
    tower = {"lowest": BASE, "middle": cube(X + 0.012, 0.0, EDGE_M)}
    leaning = cube(X + 0.024, 0.0, 2 * EDGE_M)
    # On the middle one it would stand, if that were fast.
    placement(leaning.pose, BLOCK, {"middle": tower["middle"]})
    refused = refusal(leaning, **tower)
    assert refused.why is RefusalReason.UNSTABLE
    assert "tower" in str(refused) and "lowest" in str(refused) and "middle" not in str(refused)
    straight = cube(X + 0.012, 0.0, 2 * EDGE_M)
    assert placement(straight.pose, BLOCK, tower).support == ("middle",)
    # Its weight on the other side holds it.
    back = cube(X, 0.0, 2 * EDGE_M)
    assert placement(back.pose, BLOCK, tower).cuboid.pose == back.pose


def test_the_larger_block_weighs_more() -> None:
    """Both towers are alike but for the size of the topmost block."""
    tower = {"lowest": BASE, "middle": cube(X + 0.010, 0.0, EDGE_M)}
    # Their centre of mass: 15.8 mm off for a small one, 18.4 mm for a large one; 17 mm stand.
    small, large = (
        cube(X + 0.022, 0.0, 2 * EDGE_M, (0.04, 0.04, height_m)) for height_m in (0.037, 0.093)
    )
    assert placement(small.pose, small, tower).support == ("middle",)
    assert refusal(large, **tower).why is RefusalReason.UNSTABLE


def test_a_bridge_stands_on_both_its_ends() -> None:
    left, right = cube(X, -0.03), cube(X, 0.03)
    beam = cube(X, 0.003, EDGE_M, (0.04, 0.08, 0.04))
    put = placement(beam.pose, beam, {"left": left, "right": right})
    assert sorted(put.support) == ["left", "right"]
    # Its middle is above neither, and it isn't drawn to one's middle.
    assert put.cuboid.pose == beam.pose
    # On one end alone it would fall.
    assert refusal(beam, left=left).why is RefusalReason.UNSTABLE


def test_a_bridge_stands_on_ends_that_are_nearly_level_and_falls_if_they_are_not() -> None:
    beam = cube(X, 0.0, EDGE_M, (0.04, 0.08, 0.04))

    def ends(lower_by_m: float) -> dict[str, Cuboid]:
        low = cube(X, 0.03, edges=(0.04, 0.04, EDGE_M - lower_by_m))
        return {"high": cube(X, -0.03), "low": low}

    put = placement(beam.pose, beam, ends(TOUCH_M - MM))
    assert sorted(put.support) == ["high", "low"]
    assert put.cuboid.bottom_m == pytest.approx(EDGE_M)
    refused = refusal(beam, **ends(0.008))
    assert refused.why is RefusalReason.UNSTABLE and "high" in str(refused)


def test_a_bridge_may_turn_over_what_its_ends_stand_on() -> None:
    """Each pillar hangs over what it stands on, inwards, and would stand alone."""

    def pillars(off_m: float) -> dict[str, Cuboid]:
        return {
            f"{side} {part}": cube(X, sign * y, foot_m)
            for side, sign in (("left", -1), ("right", 1))
            for part, y, foot_m in (("lower", 0.05, 0.0), ("upper", 0.05 - off_m, EDGE_M))
        }

    beam = cube(X, 0.0, 2 * EDGE_M, (0.04, 0.06, 0.04))
    refused = refusal(beam, **pillars(0.016))
    assert refused.why is RefusalReason.UNSTABLE
    assert "tower" in str(refused) and "left lower and right lower" in str(refused)
    # It bears on them farther out, or they stand straighter.
    for wide, off_m in ((cube(X, 0.0, 2 * EDGE_M, (0.04, 0.12, 0.04)), 0.016), (beam, 0.011)):
        put = placement(wide.pose, wide, pillars(off_m))
        assert put.support == ("left upper", "right upper")


SLAB: Vector3 = (0.04, 0.20, 0.04)
"""Weighs as much as five cubes."""
ON_SLAB_M = 2 * EDGE_M


def on_slab(foot: float = EDGE_M, **loads: float) -> dict[str, Cuboid]:
    """A slab on a foot of that width, with cubes at some y on it."""
    below = {
        "foot": cube(X, edges=(0.04, foot, EDGE_M)),
        "slab": cube(X, 0.0, EDGE_M, SLAB),
    }
    return below | {name: cube(X, y, ON_SLAB_M) for name, y in loads.items()}


def test_what_else_stands_on_a_block_weighs_too() -> None:
    # Centres of mass: 14 mm off for one, 18 mm for both; 17 mm stand.
    goal = cube(X, 0.085, ON_SLAB_M)
    assert placement(goal.pose, BLOCK, on_slab()).support == ("slab",)
    refused = refusal(goal, **on_slab(load=0.04))
    assert (
        refused.why is RefusalReason.UNSTABLE and "tower" in str(refused) and "foot" in str(refused)
    )
    # On the table they stand.
    on_table = {"slab": cube(X, edges=SLAB), "load": cube(X, 0.04, EDGE_M)}
    low = cube(X, 0.085, EDGE_M)
    assert placement(low.pose, BLOCK, on_table).support == ("slab",)


def test_a_block_on_the_other_side_holds_the_balance() -> None:
    goal = cube(X, 0.06, ON_SLAB_M)
    # Without it the centre of mass would be 10 mm off, and 7 mm stand.
    assert refusal(goal, **on_slab(0.02)).why is RefusalReason.UNSTABLE
    put = placement(goal.pose, BLOCK, on_slab(0.02, load=-0.04))
    assert put.support == ("slab",)
    # So do two of which one stands on the other.
    higher = {"higher": cube(X, -0.04, 3 * EDGE_M)}
    far = cube(X, 0.08, ON_SLAB_M)
    assert refusal(far, **on_slab(0.02, load=-0.02)).why is RefusalReason.UNSTABLE
    put = placement(far.pose, BLOCK, on_slab(0.02, load=-0.04) | higher)
    assert put.support == ("slab",)


def test_what_is_seen_to_stand_though_it_would_fall_is_left_out() -> None:
    # The load alone would turn the slab over, and the block in the middle would not hold it.
    goal, others = cube(X, 0.0, ON_SLAB_M), on_slab(0.02, load=0.08)
    assert refusal(others["load"], **on_slab(0.02)).why is RefusalReason.UNSTABLE
    assert placement(goal.pose, BLOCK, others).support == ("slab",)


def test_who_stands_on_whom() -> None:
    objects = {
        "lower": BASE,
        # Seen a little too high and too low.
        "upper": cube(X + 0.005, 0.0, EDGE_M + 0.002),
        "top": cube(X, 0.005, 2 * EDGE_M + 0.001),
        "beside": cube(X, 0.1),
        "hovering": cube(X, 0.1, EDGE_M + 0.01),
        "corner": cube(X + EDGE_M, 0.0, EDGE_M),
    }

    def others(name: str) -> dict[str, Cuboid]:
        return {other: cuboid for other, cuboid in objects.items() if other != name}

    def on(name: str) -> list[str]:
        return resting_on(objects[name], others(name))

    def under(name: str) -> list[str]:
        return standing_on(objects[name], others(name))

    assert on("lower") == ["upper"] and under("upper") == ["lower"]
    assert on("upper") == ["top"] and under("top") == ["upper"]
    assert on("top") == on("beside") == []
    assert under("lower") == under("beside") == [TABLE]
    # Edge to edge is not on top.
    assert under("corner") == [TABLE]


def test_a_bridge_rests_on_both_its_ends() -> None:
    objects = {"left": cube(X, -0.03), "right": cube(X, 0.03)}
    beam = cube(X, 0.0, EDGE_M, (0.04, 0.08, 0.04))
    assert standing_on(beam, objects) == ["left", "right"]
    assert resting_on(objects["left"], {"right": objects["right"], "beam": beam}) == ["beam"]
