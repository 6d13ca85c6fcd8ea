"""How long objects are tracked that are no longer seen: covered and held ones for ever, the others
for a number of images. Matching is tested with the arm and the robot."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np
import pytest
from test_cuboids import hidden, large, move, out_of_sight, put, small

from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.perception.cuboids import Face
from nsrm_harness.perception.detector import Detections
from nsrm_harness.perception.observer import Observer
from nsrm_harness.perception.relief import Relief
from nsrm_harness.perception.tracking import (
    CONFIRMED,
    MOST_TRACKS,
    UNCONFIRMED_PICTURES,
    UNSEEN_PICTURES,
    Tracker,
)
from nsrm_harness.simulation.render import Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera
from nsrm_harness.simulation.world import World

CAMERA = default_camera()
EDGE_PX = 30
TABLE_M, OBJECT_M, ARM_M = 1.0, 0.9, 0.4
"""Depths in pictures that are made up."""
STEP = 0.07
"""Between the shares of red and green of two colours that are told apart."""

Place = tuple[int, int]
"""Row and column of an object's corner."""
Color = tuple[int, int, int]
HERE, THERE = (100, 10), (300, 300)
PLACES = [(row, column) for row in range(10, 420, 40) for column in range(100, 580, 40)]
RED, GREEN, BLACK = (200, 20, 20), (20, 200, 20), (0, 0, 0)


def shown(
    tracker: Tracker,
    objects: Mapping[Place, Color],
    depth_m: float = TABLE_M,
    held: Collection[int] = (),
) -> tuple[int, ...]:
    """The numbers of objects of these colours in a picture of nothing else.

    * `depth_m`: of all that is no object
    """
    shape = (CAMERA.height, CAMERA.width)
    image, labels = np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.int32)
    depth, flat = np.full(shape, depth_m, np.float32), np.zeros(shape, np.float32)
    corners = np.zeros((len(objects), 4), np.float32)
    for index, ((row, column), rgb) in enumerate(objects.items()):
        own = np.s_[row : row + EDGE_PX, column : column + EDGE_PX]
        image[own], labels[own], depth[own] = rgb, index + 1, OBJECT_M
        corners[index] = (column, row, column + EDGE_PX, row + EDGE_PX)
    boxes = corners / np.array([*shape[::-1], *shape[::-1]], np.float32)
    found = Detections(boxes, np.full(len(boxes), OBJECT_M, np.float32), labels)
    cube = Cuboid(Pose((0.0, 0.0, 0.02)), (0.04, 0.04, 0.04))
    faces = [Face(np.zeros((1, 3), np.float32), cube)] * len(boxes)
    heights = Relief(flat, flat, flat, depth, depth, 0.0, False)
    return tracker.update(image, found, faces, heights, CAMERA, held)


def colors() -> list[Color]:
    """As many as no two pictures of one object have; none is near to black."""
    shares = np.arange(0.03, 1.0, STEP)
    found = []
    for red in shares:
        for green in shares[shares < 0.98 - red]:
            parts = np.array([red, green, 1.0 - red - green])
            r, g, b = (int(part) for part in 250 * parts / parts.max())
            if np.abs(parts - 1 / 3).max() > 0.2:
                found.append((r, g, b))
    return found


def test_what_noise_makes_is_forgotten_and_its_numbers_are_not_given_again() -> None:
    tracker = Tracker()
    (own,) = shown(tracker, {HERE: BLACK})
    given: list[int] = []
    for _ in range(3):
        for place, color in zip(PLACES, colors(), strict=False):
            numbers = shown(tracker, {HERE: BLACK, place: color})
            assert numbers[0] == own
            given.append(numbers[1])
            # What was shown in the last pictures, and no more.
            assert len(tracker) <= 1 + UNCONFIRMED_PICTURES
    assert given == list(range(own + 1, own + 1 + 3 * len(colors())))
    for _ in range(UNCONFIRMED_PICTURES):
        shown(tracker, {HERE: BLACK})
    assert len(tracker) == 1


@pytest.mark.parametrize(
    ("pictures", "patience"),
    [(CONFIRMED - 1, UNCONFIRMED_PICTURES), (CONFIRMED, UNSEEN_PICTURES)],
    ids=["unconfirmed", "confirmed"],
)
def test_an_object_is_forgotten_after_so_many_pictures_that_should_show_it(
    pictures: int, patience: int
) -> None:
    def after(unseen: int) -> tuple[Tracker, int]:
        tracker = Tracker()
        numbers = [shown(tracker, {HERE: RED}) for _ in range(pictures)]
        for _ in range(unseen):
            shown(tracker, {})
        return tracker, numbers[0][0]

    tracker, number = after(patience - 1)
    assert tracker.position(number) is not None
    assert shown(tracker, {HERE: RED}) == (number,)
    tracker, number = after(patience)
    assert tracker.position(number) is None
    assert (len(tracker), tracker.forgotten) == (0, {number})
    assert shown(tracker, {HERE: RED}) == (number + 1,)


def test_what_is_covered_or_held_is_not_forgotten() -> None:
    tracker = Tracker()
    for _ in range(CONFIRMED):
        one, other = shown(tracker, {HERE: RED, THERE: GREEN})
    for _ in range(2 * UNSEEN_PICTURES):
        shown(tracker, {}, ARM_M)
    # The place of the one is seen, but it is in the hand.
    for _ in range(2 * UNSEEN_PICTURES):
        assert shown(tracker, {THERE: GREEN}, held=[one]) == (other,)
    assert shown(tracker, {HERE: RED, THERE: GREEN}) == (one, other)


def test_of_too_many_that_are_covered_those_seen_last_are_known() -> None:
    tracker = Tracker()
    for place, color in zip(PLACES, colors(), strict=False):
        for _ in range(CONFIRMED):
            (last,) = shown(tracker, {place: color}, ARM_M)
    assert last == len(colors()) > MOST_TRACKS
    assert len(tracker) == MOST_TRACKS
    known = [number for number in range(1, last + 1) if tracker.position(number) is not None]
    assert known == list(range(last - MOST_TRACKS + 1, last + 1))


@pytest.fixture
def world() -> Iterator[World]:
    with World() as opened:
        yield opened


def test_a_hidden_block_keeps_its_number_however_long_it_is_hidden(
    renderer: Renderer, world: World
) -> None:
    observer, numbers = hidden(renderer, world)
    for _ in range(UNSEEN_PICTURES + 5):
        cuboids = observer.look()
        assert sorted(cuboids) == sorted(numbers.values())
    for moved, y in ((3, -0.15), (2, 0.15)):
        move(world, moved, Pose.upright(0.5, y, 0.025))
        observer.look()
    assert sorted(observer.seen) == sorted(numbers.values())


@pytest.mark.slow
def test_what_was_taken_away_is_forgotten_unless_the_hand_holds_it(
    renderer: Renderer, world: World
) -> None:
    put(world, (small("red"), 0.45, 0.1, 0), (large("green"), 0.55, -0.1, 0))
    observer = Observer(SimulatedCamera(renderer, world, CAMERA))
    for _ in range(CONFIRMED):
        first = observer.look()
    (red,) = (n for n, cuboid in first.cuboids.items() if cuboid.pose.position[1] > 0.0)
    there = world.pose(1)
    out_of_sight(world, 1)
    for _ in range(UNSEEN_PICTURES + 5):
        observer.look(held=[red])
    move(world, 1, there)
    assert red in observer.look().locations
    out_of_sight(world, 1)
    for _ in range(UNSEEN_PICTURES):
        observer.look()
    move(world, 1, there)
    again = set(observer.look().locations) - set(first.locations)
    assert again == {max(first.locations) + 1}
