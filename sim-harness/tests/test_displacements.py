"""Objects that are pushed during a pick and place are reported, whichever try it was."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing

import pytest
from arm_scenes import BESIDE, Numb, Still, at_home, known, three
from test_relocation import no_room

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.displacements import DISPLACED_M, DisplacementTracker
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import (
    MAX_TRIES,
    ExecutionOptions,
    Look,
    ManipulationError,
    reach_sub_goal,
)
from nsrm_harness.simulation.arm_world import ArmWorld

PUSHED_M = 0.006


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


def pushing(
    world: ArmWorld,
    event: str,
    number: int,
    by_m: float = PUSHED_M,
    times: int = 1,
    also: Callable[[str], None] = lambda event: None,
) -> Callable[[str], None]:
    """A mark at which a block is pushed along y, so many times in all."""
    left = times

    def mark(done: str) -> None:
        nonlocal left
        also(done)
        if done == event and left:
            left -= 1
            x, y, z = world.pose(number).position
            world.place(number, Pose.upright(x, y + by_m, z))

    return mark


def test_what_was_pushed_in_a_try_that_failed_is_told(world: ArmWorld) -> None:
    three(world)
    body = Numb(world, until="not grasped")
    mark = pushing(world, "reached", 3, also=body.mark)
    performed = reach_sub_goal(
        body, PickAndPlacePlanner(), known(world), "1", BESIDE, ExecutionOptions(mark=mark)
    )
    assert performed.tries == 2
    ((name, shift_m),) = performed.shifted
    assert name == "3" and shift_m == pytest.approx(PUSHED_M, abs=0.0005)
    assert f"; 3 was pushed by {1000 * shift_m:.1f} mm" in str(performed)


def test_what_is_pushed_a_little_at_each_try_is_told(world: ArmWorld) -> None:
    three(world)
    body = Numb(world, until="not grasped")
    mark = pushing(world, "reached", 3, 0.7 * DISPLACED_M, 2, body.mark)
    performed = reach_sub_goal(
        body, PickAndPlacePlanner(), known(world), "1", BESIDE, ExecutionOptions(mark=mark)
    )
    ((name, shift_m),) = performed.shifted
    assert name == "3" and shift_m == pytest.approx(1.4 * DISPLACED_M, abs=0.0005)


def test_what_was_pushed_is_told_where_all_tries_fail(world: ArmWorld) -> None:
    three(world)
    body = Numb(world)
    with pytest.raises(
        ManipulationError, match=r"; giving up; 3 was pushed by 6\.\d mm$"
    ) as caught:
        reach_sub_goal(
            body,
            PickAndPlacePlanner(),
            known(world),
            "1",
            BESIDE,
            ExecutionOptions(mark=pushing(world, "reached", 3)),
        )
    ((name, shift_m),) = caught.value.shifted
    assert name == "3" and shift_m == pytest.approx(PUSHED_M, abs=0.0005)
    assert at_home(world)


@pytest.mark.parametrize("until", ["cleared", ""], ids=["the block fails", "its blocker fails"])
def test_what_was_pushed_is_told_where_clearing_fails_or_what_follows(
    world: ArmWorld, until: str
) -> None:
    goal, _, _ = no_room(world)
    body = Numb(world, since=until)
    mark = pushing(world, "reached", 3, also=body.mark)
    with pytest.raises(ManipulationError) as caught:
        reach_sub_goal(
            body, PickAndPlacePlanner(), known(world), "1", goal, ExecutionOptions(mark=mark)
        )
    assert [name for name, _ in caught.value.shifted] == ["3"]
    assert str(caught.value).count("was pushed by") == 1


def test_what_is_no_longer_seen_is_told(world: ArmWorld) -> None:
    three(world)
    gone: list[str] = []

    def unseen(look: Look) -> Look:
        return lambda: {name: cuboid for name, cuboid in look().items() if name not in gone}

    def mark(event: str) -> None:
        if event == "above":
            gone.append("3")

    performed = reach_sub_goal(
        world, PickAndPlacePlanner(), unseen(known(world)), "1", BESIDE, ExecutionOptions(mark=mark)
    )
    assert performed.shifted == (("3", math.inf),)
    assert str(performed).endswith("; 3 is no longer seen")
    assert json.loads(json.dumps(performed.as_json(), allow_nan=False))["shifted_m"] == {"3": None}


def seen(**at_m: float) -> Mapping[str, Cuboid]:
    return {
        name: Cuboid(Pose.upright(0.5, y, 0.02), (0.04, 0.04, 0.04)) for name, y in at_m.items()
    }


def test_what_was_carried_has_not_been_pushed() -> None:
    shifts = DisplacementTracker()
    shifts.see(seen(red=0.0, blue=0.1, green=0.2))
    shifts.see(seen(red=0.0, blue=0.3, green=0.2), "blue")
    assert shifts.besides("red") == ()
    # From where it is since then.
    shifts.see(seen(red=0.1, blue=0.305, green=0.201), "red")
    assert shifts.besides("red") == (("blue", pytest.approx(0.005)),)


def test_the_farthest_is_told_and_what_is_seen_again_is_not_lost() -> None:
    shifts = DisplacementTracker()
    for blue in (0.1, 0.11, 0.1):
        shifts.see(seen(red=0.0, blue=blue))
    assert shifts.besides("red") == (("blue", pytest.approx(0.01)),)
    shifts.see(seen(red=0.0))
    assert shifts.besides("red") == (("blue", math.inf),)
    shifts.see(seen(red=0.0, blue=0.1))
    assert shifts.besides("red") == (("blue", pytest.approx(0.01)),)


@pytest.mark.parametrize("tries", [0, -1])
def test_no_try_at_all_is_a_mistake_that_is_named_before_anything_moves(
    world: ArmWorld, tries: int
) -> None:
    three(world)
    with pytest.raises(ValueError, match=f"tries: expected 1 or more, got {tries}"):
        reach_sub_goal(
            Still(world),
            PickAndPlacePlanner(),
            known(world),
            "1",
            BESIDE,
            ExecutionOptions(tries=tries),
        )


def test_one_try_is_one(world: ArmWorld) -> None:
    three(world)
    assert MAX_TRIES > 1
    with pytest.raises(ManipulationError, match="1 was tried once and is"):
        reach_sub_goal(
            Numb(world), PickAndPlacePlanner(), known(world), "1", BESIDE, ExecutionOptions(tries=1)
        )
