"""Blocks as cuboids from images: where they are, and what is assumed of hidden ones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from world_scenes import DOMAIN, on_top, random_blocks

from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.perception import observer
from nsrm_harness.perception.cuboids import Cuboids, faces
from nsrm_harness.perception.detector import detect
from nsrm_harness.perception.relief import relief
from nsrm_harness.perception.tracking import Tracker
from nsrm_harness.simulation.blocks import Block, block_from_attributes
from nsrm_harness.simulation.layout import sample_layout
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera
from nsrm_harness.simulation.world import World

CENTRE_M = 0.001
EDGE_M = 0.0015
YAW_RAD = math.radians(1.0)
YAW = 0.15
"""Of most blocks, radians."""
FLAT: Vector3 = (0.06, 0.03, 0.03)
"""Of a block that is not square."""
FREE = Pose.upright(0.55, 0.2, 0.02)


class Tracking:
    """A picture after the other, and who is who in them."""

    def __init__(self, renderer: Renderer, world: World) -> None:
        self._renderer, self._world = renderer, world
        self._camera, self._tracker = default_camera(), Tracker()
        self._cuboids = Cuboids(self._camera)
        self.seen: tuple[int, ...] = ()
        """The numbers of what was in the last picture."""

    def look(self) -> dict[int, Cuboid]:
        frame = self._renderer.render(self._world, self._camera, Light())
        found = detect(frame.rgb, frame.depth, self._camera)
        heights = relief(frame.rgb, frame.depth, self._camera)
        seen = faces(found, heights, self._camera)
        self.seen = self._tracker.update(frame.rgb, found, seen, heights, self._camera)
        self._cuboids.forget(self._tracker.forgotten)
        return self._cuboids.update(dict(zip(self.seen, seen, strict=True)), heights)

    def numbers(self) -> dict[int, int]:
        """Which number each block of the world has, by where both are in a new picture."""
        cuboids = self.look()
        return {
            placed.id: min(
                cuboids, key=lambda number, at=placed.pose: cuboids[number].pose.distance_m(at)
            )
            for placed in self._world.placed()
        }


def small(color: str) -> Block:
    return block_from_attributes(DOMAIN, {"color": color, "size": "small"})


def large(color: str) -> Block:
    return block_from_attributes(DOMAIN, {"color": color, "size": "lego"})


def put(world: World, *blocks: tuple[Block, float, float, float]) -> None:
    """Each at x and y, its foot at that height."""
    world.reset()
    poses = [Pose.upright(x, y, foot + block.edges_m[2] / 2, YAW) for block, x, y, foot in blocks]
    world.spawn([block for block, *_ in blocks], poses)
    assert world.settle().at_rest


def move(world: World, moved: int, goal: Pose) -> None:
    world.place(moved, goal)
    assert world.settle().at_rest
    assert world.pose(moved).distance_m(goal) < 0.001


def onto(world: World, moved: int, reference: int) -> Pose:
    """On its middle, turned as it is."""
    return replace(on_top(world, moved, reference), orientation=world.pose(reference).orientation)


def check(world: World, block_id: int, cuboid: Cuboid, what: object = None) -> None:
    """Whether the box is where and as large as the block is."""
    (block,) = (placed for placed in world.placed() if placed.id == block_id)
    edges = block.block.edges_m
    assert cuboid.pose.distance_m(block.pose) < CENTRE_M, what
    turn = cuboid.pose.yaw_rad() - block.pose.yaw_rad()
    if round(turn / (math.pi / 2)) % 2:
        # Turned by a quarter, it looks the same with its edges the other way round.
        edges = (edges[1], edges[0], edges[2])
    off = (turn + math.pi / 4) % (math.pi / 2) - math.pi / 4
    assert abs(off) < YAW_RAD, what
    np.testing.assert_allclose(cuboid.edges_m, edges, atol=EDGE_M, err_msg=str(what))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("max_yaw", [40.0, 0.0])
def test_blocks_are_where_and_as_they_are(
    renderer: Renderer, world: World, max_yaw: float, seed: int
) -> None:
    """Turned in many ways, and as an arm leaves them: along the rows of the picture."""
    rng = np.random.default_rng(100 + seed)
    blocks = random_blocks(rng, 6)
    blocks[0] = replace(blocks[0], edges_m=FLAT, studs=None)
    world.reset()
    world.spawn(blocks, sample_layout(rng, blocks, max_yaw_rad=math.radians(max_yaw)))
    assert world.settle().at_rest
    tracking = Tracking(renderer, world)
    numbers, cuboids = tracking.numbers(), tracking.look()
    assert len(cuboids) == 6 and len(set(numbers.values())) == 6
    for block_id, number in numbers.items():
        check(world, block_id, cuboids[number], f"seed {seed}, block {block_id}")


def test_a_block_keeps_its_box_when_another_is_put_on_it(renderer: Renderer, world: World) -> None:
    for lower, upper in (
        (small("red"), small("green")),
        (large("red"), small("green")),
        (small("red"), large("green")),
        (large("blue"), large("blue")),
    ):
        put(world, (lower, 0.5, 0.1, 0), (upper, 0.45, -0.1, 0), (small("white"), 0.6, 0.0, 0))
        tracking = Tracking(renderer, world)
        numbers, before = tracking.numbers(), tracking.look()
        move(world, 2, onto(world, 2, 1))
        for _ in range(3):
            cuboids = tracking.look()
            assert sorted(cuboids) == sorted(numbers.values())
            for block_id, number in numbers.items():
                check(world, block_id, cuboids[number], (lower.values, upper.values, block_id))
        standing, on_it = cuboids[numbers[1]], cuboids[numbers[2]]
        assert standing.pose.distance_m(before[numbers[1]].pose) < CENTRE_M
        assert on_it.bottom_m == pytest.approx(standing.top_m, abs=1e-6)


def test_a_tower_is_seen_as_its_blocks_while_it_is_built(renderer: Renderer, world: World) -> None:
    put(
        world,
        (large("red"), 0.5, 0.0, 0),
        (small("green"), 0.4, -0.15, 0),
        (small("blue"), 0.5, -0.15, 0),
        (small("yellow"), 0.6, -0.15, 0),
    )
    tracking = Tracking(renderer, world)
    numbers = tracking.numbers()
    for moved in (2, 3, 4):
        move(world, moved, onto(world, moved, moved - 1))
        cuboids = tracking.look()
        for block_id, number in numbers.items():
            check(world, block_id, cuboids[number], (moved, block_id))
    # And while it is taken down.
    for moved in (4, 3):
        move(world, moved, Pose.upright(0.4 + 0.05 * moved, -0.15, 0.02, YAW))
        cuboids = tracking.look()
        for block_id, number in numbers.items():
            check(world, block_id, cuboids[number], (moved, block_id))


def test_a_block_that_was_moved_is_only_where_it_is_now(renderer: Renderer, world: World) -> None:
    put(world, (small("red"), 0.45, 0.1, 0), (small("green"), 0.55, -0.1, 0))
    tracking = Tracking(renderer, world)
    numbers = tracking.numbers()
    move(world, 1, Pose.upright(0.6, 0.15, 0.02, 0.3))
    cuboids = tracking.look()
    assert sorted(cuboids) == sorted(numbers.values())
    for block_id, number in numbers.items():
        check(world, block_id, cuboids[number])


def out_of_sight(world: World, moved: int) -> None:
    """At the table's edge beside the robot."""
    move(world, moved, Pose.upright(0.0, 0.6, 0.02, YAW))


def test_a_block_that_was_taken_away_is_believed_no_more(renderer: Renderer, world: World) -> None:
    put(world, (small("red"), 0.45, 0.1, 0), (small("green"), 0.55, -0.1, 0))
    tracking = Tracking(renderer, world)
    numbers = tracking.numbers()
    out_of_sight(world, 1)
    assert list(tracking.look()) == [numbers[2]]
    # From a tower too: then the lower one is still there.
    put(world, (small("red"), 0.45, 0.1, 0), (small("green"), 0.55, -0.1, 0))
    tracking = Tracking(renderer, world)
    numbers = tracking.numbers()
    move(world, 2, onto(world, 2, 1))
    tracking.look()
    out_of_sight(world, 2)
    cuboids = tracking.look()
    assert list(cuboids) == [numbers[1]]
    check(world, 1, cuboids[numbers[1]])


def in_the_open(renderer: Renderer, world: World) -> tuple[Tracking, dict[int, int]]:
    """A red block, and two large ones that don't hide it yet."""
    put(
        world,
        (small("red"), 0.40, 0.0, 0),
        (large("green"), 0.5, 0.15, 0),
        (large("blue"), 0.5, -0.15, 0),
    )
    tracking = Tracking(renderer, world)
    numbers = tracking.numbers()
    return tracking, numbers


def hidden(renderer: Renderer, world: World) -> tuple[Tracking, dict[int, int]]:
    """The red block, seen before a tower of two large ones was built in front of it."""
    tracking, numbers = in_the_open(renderer, world)
    move(world, 2, Pose.upright(0.46, 0.0, 0.025, YAW))
    tracking.look()
    move(world, 3, onto(world, 3, 2))
    return tracking, numbers


def test_a_block_that_is_wholly_hidden_is_believed_to_be_there(
    renderer: Renderer, world: World
) -> None:
    tracking, numbers = hidden(renderer, world)
    for _ in range(3):
        cuboids = tracking.look()
        assert sorted(tracking.seen) == sorted((numbers[2], numbers[3]))
        for block_id, number in numbers.items():
            check(world, block_id, cuboids[number], block_id)
    # It comes to light again as the same one.
    for moved, y in ((3, -0.15), (2, 0.15)):
        move(world, moved, Pose.upright(0.5, y, 0.025, YAW))
        cuboids = tracking.look()
        for block_id, number in numbers.items():
            check(world, block_id, cuboids[number], (moved, block_id))
    assert sorted(tracking.seen) == sorted(numbers.values())


def test_a_block_that_went_unseen_is_believed_until_its_place_is_seen(
    renderer: Renderer, world: World
) -> None:
    tracking, numbers = hidden(renderer, world)
    tracking.look()
    out_of_sight(world, 1)
    assert numbers[1] in tracking.look()
    move(world, 3, Pose.upright(0.5, -0.15, 0.025, YAW))
    move(world, 2, Pose.upright(0.5, 0.15, 0.025, YAW))
    assert sorted(tracking.look()) == sorted((numbers[2], numbers[3]))


def test_a_block_that_is_partly_hidden_keeps_its_box(renderer: Renderer, world: World) -> None:
    tracking, numbers = in_the_open(renderer, world)
    move(world, 2, Pose.upright(0.46, 0.03, 0.025, YAW))
    tracking.look()
    move(world, 3, Pose.upright(0.46, 0.03, 0.075, YAW))
    cuboids = tracking.look()
    assert len(tracking.seen) == 3
    assert sorted(cuboids) == sorted(numbers.values())
    for block_id, number in numbers.items():
        check(world, block_id, cuboids[number], block_id)


def test_where_all_of_a_covered_block_is_is_remembered_until_it_moves(renderer: Renderer) -> None:
    with World() as world:
        world.spawn([small("red"), small("blue")], [Pose.upright(0.45, 0.0, 0.02), FREE])
        world.settle()
        tracking = observer.Observer(SimulatedCamera(renderer, world, default_camera()))
        first = tracking.look()
        lower = next(key for key in first.cuboids if first.cuboids[key].pose.position[1] < 0.1)
        assert all((first.whole[key] == first.locations[key]).all() for key in first.locations)
        world.place(2, on_top(world, 2, 1))
        world.settle()
        covered = tracking.look()
        np.testing.assert_array_equal(covered.whole[lower], first.locations[lower])
        assert (first.covered, covered.covered) == (set(), {lower})
        # Its upper part is behind the other one.
        assert covered.locations[lower][1] > first.locations[lower][1] + 0.01
        for block_id in (1, 2):
            x, y, z = world.pose(block_id).position
            world.place(block_id, Pose((x, y - 0.1, z), (0.0, 0.0, 0.0, 1.0)))
        world.settle()
        moved = tracking.look()
        np.testing.assert_array_equal(moved.whole[lower], moved.locations[lower])
        # Half of it is visible there: what the camera shows of it is not how it looks.
        assert moved.covered == {lower}
        world.place(2, FREE)
        world.settle()
        assert not tracking.look().covered
        np.testing.assert_array_equal(
            tracking.look().whole[lower], tracking.look().locations[lower]
        )


@pytest.mark.parametrize(("y", "yaw"), [(0.052, 0.0), (0.055, 0.1)])
def test_a_block_that_is_moved_behind_a_tower_keeps_its_edges(
    renderer: Renderer, y: float, yaw: float
) -> None:
    large = block_from_attributes(DOMAIN, {"color": "red", "size": "lego"})
    moved = small("green")
    with World() as world:
        half = moved.edges_m[2] / 2
        tower = [Pose.upright(0.56, 0.12, 0.025 + 0.05 * level) for level in range(2)]
        world.spawn([large] * 2 + [moved], [*tower, Pose.upright(0.42, -0.22, half)])
        world.settle()
        tracking = Tracking(renderer, world)
        number = tracking.numbers()[3]
        world.place(3, Pose.upright(0.515 - moved.edges_m[0] / 2, 0.12 + y, half + 0.003, yaw))
        world.settle()
        seen = tracking.look()[number]
        assert seen.pose.distance_m(world.pose(3)) < 0.002
        assert sorted(seen.edges_m) == pytest.approx(sorted(moved.edges_m), abs=EDGE_M)
        # Only a part of it is in view.
        alone = Tracking(renderer, world).look()
        parts = [c for c in alone.values() if c.pose.distance_m(world.pose(3)) < 0.03]
        assert parts and min(parts[0].edges_m[:2]) < min(moved.edges_m[:2]) - EDGE_M


def test_a_block_that_is_moved_to_where_a_sliver_is_seen_keeps_its_number(
    renderer: Renderer, world: World
) -> None:
    put(
        world,
        (large("green"), 0.502, -0.013, 0.0),
        (large("white"), 0.502, -0.013, 0.05),
        (large("red"), 0.426, 0.088, 0.0),
        (small("cyan"), 0.42, 0.18, 0.0),
    )
    tracking = Tracking(renderer, world)
    named = tracking.numbers()
    move(world, 4, Pose.upright(0.426, 0.013, 0.02, YAW))
    tracking.look()
    assert sorted(tracking.seen) == sorted(named.values())
    # It is that little that is in view.
    alone = Tracking(renderer, world).look()
    parts = [c for c in alone.values() if c.pose.distance_m(world.pose(4)) < 0.03]
    assert parts and min(parts[0].edges_m[:2]) < 0.5 * min(small("cyan").edges_m[:2])
    # And it is known by its whole again.
    move(world, 4, Pose.upright(0.36, 0.2, 0.02, YAW))
    assert tracking.numbers() == named
    check(world, 4, tracking.look()[named[4]])


def test_what_is_left_to_see_of_one_is_not_taken_for_another_that_was_moved(
    renderer: Renderer, world: World
) -> None:
    put(
        world,
        (small("magenta"), 0.364, -0.046, 0.0),
        (large("magenta"), 0.378, 0.232, 0.0),
        (large("blue"), 0.505, 0.169, 0.0),
        (large("red"), 0.606, -0.16, 0.0),
        (large("green"), 0.501, 0.013, 0.0),
    )
    tracking = Tracking(renderer, world)
    named = tracking.numbers()
    for moved, reference in ((4, 3), (5, 4), (1, 5)):
        move(world, moved, onto(world, moved, reference))
        cuboids = tracking.look()
        assert cuboids[named[moved]].pose.distance_m(world.pose(moved)) < 0.003
    # The large one behind the tower is believed where it stands.
    check(world, 2, cuboids[named[2]])
    assert named[2] in tracking.seen


@pytest.mark.parametrize(("x", "y"), [(0.36, -0.2), (0.6, 0.2), (0.45, 0.0)])
def test_one_that_lies_where_another_of_its_colour_stood_is_not_what_is_left_to_see_of_it(
    renderer: Renderer, world: World, x: float, y: float
) -> None:
    """A small block was to go onto a large one of its colour, which was snatched away under it."""
    put(
        world,
        (large("yellow"), 0.5, 0.1, 0.0),
        (large("white"), 0.5, 0.1, 0.05),
        (small("white"), 0.42, -0.1, 0.0),
    )
    tracking = Tracking(renderer, world)
    named = tracking.numbers()
    world.place(2, Pose.upright(x, y, 0.025, YAW))
    move(world, 3, onto(world, 3, 1))
    assert tracking.numbers() == named
    check(world, 2, tracking.look()[named[2]])
    check(world, 3, tracking.look()[named[3]])


@pytest.mark.parametrize(
    ("yaw", "dx", "dy"), [(0.2, 0.006, 0.0), (0.6, 0.0, 0.008), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
)
def test_a_block_keeps_its_height_where_little_is_seen_of_what_it_stands_on(
    renderer: Renderer, world: World, yaw: float, dx: float, dy: float
) -> None:
    """Both were moved at once, as when the fingers take along what a block was lowered onto."""
    put(world, (small("magenta"), 0.498, 0.148, 0.0), (small("cyan"), 0.561, 0.162, 0.0))
    tracking = Tracking(renderer, world)
    named = tracking.numbers()
    world.place(2, Pose.upright(0.498, 0.148, 0.02, yaw))
    move(world, 1, Pose.upright(0.498 + dx, 0.148 + dy, 0.06, yaw))
    check(world, 1, tracking.look()[named[1]])


TOWER = (("green", 0.0), ("blue", 0.05), ("green", 0.1))


def test_a_block_of_which_a_part_was_seen_first_keeps_its_number_when_it_comes_to_light(
    renderer: Renderer, world: World
) -> None:
    put(
        world,
        (large("red"), 0.40, 0.0, 0.0),
        *((large(color), 0.465, 0.045, foot) for color, foot in TOWER),
        (small("red"), 0.45, -0.2, 0.0),
    )
    tracking = Tracking(renderer, world)
    named = tracking.numbers()
    first = tracking.look()[named[1]]
    assert min(first.edges_m[:2]) < min(large("red").edges_m[:2]) - 0.006
    for moved, y in ((4, -0.1), (3, 0.0), (2, 0.15)):
        move(world, moved, Pose.upright(0.6, y, 0.025, YAW))
        tracking.look()
    assert tracking.numbers() == named
    check(world, 1, tracking.look()[named[1]])
