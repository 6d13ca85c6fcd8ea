"""Who is who across pictures: the detector numbers objects anew in each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from nsrm_harness.perception.cuboids import Face
from nsrm_harness.perception.detector import Detections
from nsrm_harness.world.camera import Camera

STAYED_M = 0.015
"""An object that is seen within this of where it was has not been moved."""
SAME_CHROMA = 0.06
"""Shares of red and green of two pictures of one object differ by less: light and shade
change them little, another colour by 0.15 and more."""
MIXED_CHROMA = 0.15
"""Those of a sliver differ by less than that: the pixels along its edges show what is beside it,
too."""
EDGE = 0.005
"""What is left to see of an object lies within its box, but for so much of the image."""
SAME_SIZE = 0.25
"""Widths of two pictures of one object mostly differ by less than this share,"""
ANY_SIZE = 0.5
"""and none is ever wider by more: a cube that is seen over an edge is 1.4 times as wide."""

LARGER_M = 0.005
"""An object whose upper face is larger than that of one seen before by more, in either edge, is
another one, or that one was not seen whole."""

HIDDEN, MOVED, TURNED, MOVED_BEHIND, SLIVER, LARGER, NEW, NEVER = (
    1.0,
    2.0,
    3.0,
    4.0,
    5.0,
    6.0,
    10.0,
    1000.0,
)
"""What it costs to believe that an object is hidden in part where it stands, was moved, was moved
and shows another side, was moved to where it is hidden in part, shows so little of itself where
it stands that its colour is mixed with another, was never seen whole before, or is new."""
NEAR_M = 0.05
"""What is left to see of an object lies nearer to its middle; another that stands in front of it
does not."""


@dataclass(frozen=True, eq=False)
class Track:
    """An object as it was seen last.

    * `position`: of the middle of its box at its mean depth, world frame, metres
    * `chroma`: `[2]`, shares of red and green in its mean colour
    * `width_m`: of its box at its mean depth
    * `edges_m`: of its upper face, the longer one first; the most that was seen of them
    * `box`: x1, y1, x2, y2 as fractions of the image
    """

    position: NDArray[np.float64]
    chroma: NDArray[np.float64]
    width_m: float
    edges_m: tuple[float, float]
    box: NDArray[np.float32]

    def seen_again(self, before: Track) -> tuple[float, Track]:
        """What it costs to believe that this is an object that was there before, and what is
        known of it then."""
        cost, known = self._looks_like(before)
        own, its = self.edges_m, before.edges_m
        if own[0] > its[0] + LARGER_M or own[1] > its[1] + LARGER_M:
            cost = max(cost, LARGER)
        return cost, replace(known, edges_m=(max(own[0], its[0]), max(own[1], its[1])))

    def _looks_like(self, before: Track) -> tuple[float, Track]:
        """The same by colour, place and width."""
        off = np.abs(self.chroma - before.chroma).max()
        distance_m = float(np.linalg.norm(self.position - before.position))
        if off >= SAME_CHROMA:
            is_sliver = off < MIXED_CHROMA and self._lies_within(before)
            return (SLIVER + distance_m / NEAR_M if is_sliver else NEVER), before
        ratio = math.log(self.width_m / before.width_m)
        if abs(ratio) < SAME_SIZE and distance_m <= STAYED_M:
            return distance_m, self
        costs = [(NEVER, before)]
        if self._lies_within(before):
            # By its whole look it is known again.
            costs.append((HIDDEN + distance_m / NEAR_M, before))
        if abs(ratio) < SAME_SIZE:
            costs.append((MOVED + distance_m, self))
        elif abs(ratio) < ANY_SIZE:
            costs.append((TURNED + distance_m, self))
        elif ratio < 0:
            costs.append((MOVED_BEHIND + distance_m, replace(self, width_m=before.width_m)))
        return min(costs, key=lambda cost: cost[0])

    def _lies_within(self, before: Track) -> bool:
        low, high = self.box[:2] >= before.box[:2] - EDGE, self.box[2:] <= before.box[2:] + EDGE
        return bool(low.all() and high.all())


class Tracker:
    """Gives each object one number for as long as it is there."""

    def __init__(self) -> None:
        self._tracks: dict[int, Track] = {}
        self._next = 1

    def update(
        self,
        image: NDArray[np.uint8],
        found: Detections,
        seen_faces: Sequence[Face],
        camera: Camera,
    ) -> tuple[int, ...]:
        """The number of each object found; an object that is hidden keeps its own.

        * `seen_faces`: of each

        All are matched at once, so that what has to be believed is as little as possible: that an
        object stays, that a part of it is hidden, that it was moved, in this order. Who can be
        none of those that were there is new.
        """
        seen = [_track(image, found, row, face, camera) for row, face in enumerate(seen_faces)]
        numbers = list(self._tracks)
        again = [[new.seen_again(self._tracks[number]) for number in numbers] for new in seen]
        costs = np.full((len(seen), len(numbers) + len(seen)), NEW)
        for row, known in enumerate(again):
            costs[row, : len(numbers)] = [cost for cost, _ in known]
        names: list[int] = []
        for row, column in zip(*linear_sum_assignment(costs), strict=True):
            if column < len(numbers):
                names.append(numbers[column])
                self._tracks[names[-1]] = again[row][column][1]
            else:
                names.append(self._next)
                self._tracks[names[-1]] = seen[row]
                self._next += 1
        return tuple(names)

    def position(self, number: int) -> NDArray[np.float64] | None:
        """Where an object was seen last, world frame, metres; None if it never was."""
        track = self._tracks.get(number)
        return None if track is None else track.position


def _track(
    image: NDArray[np.uint8], found: Detections, row: int, face: Face, camera: Camera
) -> Track:
    x1, y1, x2, y2 = (float(value) for value in found.boxes[row])
    depth = float(found.depths[row])
    middle = ((x1 + x2) / 2 * camera.width, (y1 + y2) / 2 * camera.height, depth)
    color = image[found.labels == row + 1].mean(axis=0) + 1.0
    a, b, _ = face.cuboid.edges_m
    return Track(
        camera.back_project(middle),
        color[:2] / color.sum(),
        (x2 - x1) * camera.width / camera.fx * depth,
        (max(a, b), min(a, b)),
        found.boxes[row],
    )
