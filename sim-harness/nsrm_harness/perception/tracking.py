"""Tracks objects across images, since the detector numbers them anew in each.

An object that could be seen but is not is forgotten after some images: otherwise objects caused by
noise would stay for ever and cost time in every later image.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.perception.cuboids import Face
from nsrm_harness.perception.detector import Detections
from nsrm_harness.perception.relief import Relief

STAYED_M = 0.015
"""An object seen within this distance of where it was has not been moved."""
SAME_CHROMA = 0.06
"""Shares of red and green of one object in two images differ by less than this: light and shade
change them little, another colour by 0.15 and more."""
MIXED_CHROMA = 0.15
"""Those of a sliver differ by less than this: the pixels along its edges also show its
neighbours."""
EDGE = 0.005
"""The visible part of an object lies within its box, with this tolerance in image sizes."""
SAME_SIZE = 0.25
"""Widths of one object in two images mostly differ by less than this share,"""
ANY_SIZE = 0.5
"""and never by more than this: a cube seen over an edge is 1.4 times as wide."""

LARGER_M = 0.005
"""If the top face of an object exceeds that of an earlier one by more than this, in either edge, it
is a different object, or the earlier one was not seen whole."""

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
"""Costs of assuming that an object: is partly hidden at its place; was moved; was moved and shows
another side; was moved to where it is partly hidden; shows so little at its place that its colour
is mixed with another one; was never seen whole before; or is new."""
NEAR_M = 0.05
"""The visible part of an object is closer to its middle than this; an object in front of it is
not."""

CONFIRMED = 3
"""An object is confirmed once this many images have shown it."""
UNCONFIRMED_PICTURES, UNSEEN_PICTURES = 5, 100
"""Numbers of images that should show an object and do not, after which an unconfirmed and a
confirmed object are forgotten; the latter is 10 s at the ten images per second of a robot's
camera."""
MOST_TRACKS = 64
"""Largest number of tracked objects. Beyond it, unconfirmed objects are forgotten first, then those
that should be seen and are not, then those that were not seen for the longest time."""
SAMPLES = 64
"""Largest number of an object's pixels that are checked for whether it is covered:"""
COVERED_SHARE, COVERS_M = 0.5, 0.01
"""it is, if this share of them shows something closer to the camera by this distance,
or nothing."""


@dataclass(frozen=True, eq=False)
class Track:
    """An object as it was last seen.

    * `position`: centre of its box at its mean depth, world frame, metres
    * `chroma`: `[2]`, shares of red and green in its mean colour
    * `width_m`: width of its box at its mean depth
    * `edges_m`: edges of its top face, the longer one first; the largest that were seen
    * `box`: x1, y1, x2, y2 as fractions of the image
    * `rows`, `columns`, `depths`: `[n]`, some of the pixels that showed it
    """

    position: NDArray[np.float64]
    chroma: NDArray[np.float64]
    width_m: float
    edges_m: tuple[float, float]
    box: NDArray[np.float32]
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    depths: NDArray[np.float32]

    def seen_again(self, before: Track) -> tuple[float, Track]:
        """The cost of assuming that this is an earlier object, and the resulting track."""
        cost, known = self._looks_like(before)
        own, its = self.edges_m, before.edges_m
        if own[0] > its[0] + LARGER_M or own[1] > its[1] + LARGER_M:
            cost = max(cost, LARGER)
        return cost, replace(known, edges_m=(max(own[0], its[0]), max(own[1], its[1])))

    def is_covered(self, seen: Relief) -> bool:
        """Whether an image shows something else where this object was."""
        nearer = seen.depth[self.rows, self.columns] < self.depths - COVERS_M
        return float(nearer.mean()) >= COVERED_SHARE

    def _looks_like(self, before: Track) -> tuple[float, Track]:
        """The same cost and track, by colour, place and width."""
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
            # Its whole appearance identifies it.
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


@dataclass
class _Life:
    """How often an object has been seen, in numbers of images.

    * `shown`: images that have shown it
    * `missed`: images since the last of them that should have shown it
    * `absent`: all images since the last of them
    """

    shown: int = 0
    missed: int = 0
    absent: int = 0

    def is_seen(self) -> None:
        """Records that an image shows it."""
        self.shown, self.missed, self.absent = self.shown + 1, 0, 0

    @property
    def is_confirmed(self) -> bool:
        return self.shown >= CONFIRMED

    @property
    def is_over(self) -> bool:
        """Whether too many images should have shown it and did not."""
        return self.missed >= (UNSEEN_PICTURES if self.is_confirmed else UNCONFIRMED_PICTURES)

    @property
    def doubt(self) -> tuple[bool, int, int]:
        """Sort key: the greater, the sooner it is forgotten."""
        return (not self.is_confirmed, self.missed, self.absent)


class Tracker:
    """Gives each object a number that it keeps and that no other object ever gets.

    Covered and held objects are not forgotten. Memory, and the time per image, are bounded by
    `MOST_TRACKS`.
    """

    def __init__(self) -> None:
        self._tracks: dict[int, Track] = {}
        self._lives: dict[int, _Life] = {}
        self._next = 1
        self.forgotten: frozenset[int] = frozenset()
        """The objects that were forgotten with the last image."""

    def __len__(self) -> int:
        """Number of tracked objects."""
        return len(self._tracks)

    def update(
        self,
        image: NDArray[np.uint8],
        found: Detections,
        seen_faces: Sequence[Face],
        heights: Relief,
        camera: Camera,
        held: Collection[int] = (),
    ) -> tuple[int, ...]:
        """Returns the number of each detected object; hidden objects keep theirs.

        * `seen_faces`: top face of each
        * `heights`: heights of the image
        * `held`: the objects that a hand may hold, so that they are not where they were

        All objects are matched at once, at the smallest total cost of assumptions: that an object
        stays, that a part of it is hidden, that it was moved, in this order. An object that matches
        no earlier one is new.
        """
        seen = [
            _track(image, found, row, face, heights, camera) for row, face in enumerate(seen_faces)
        ]
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
                self._tracks[names[-1]], self._lives[names[-1]] = seen[row], _Life()
                self._next += 1
        self._forget(names, heights, held)
        return tuple(names)

    def _forget(self, names: Collection[int], heights: Relief, held: Collection[int]) -> None:
        """Records an image that shows the objects `names`; forgets those that are over."""
        unseen = []
        for number, life in self._lives.items():
            if number in names:
                life.is_seen()
                continue
            life.absent += 1
            if number in held:
                continue
            unseen.append(number)
            life.missed += not self._tracks[number].is_covered(heights)
        unseen.sort(key=lambda number: self._lives[number].doubt, reverse=True)
        over = [number for number in unseen if self._lives[number].is_over]
        rest = [number for number in unseen if not self._lives[number].is_over]
        too_many = max(len(self._lives) - len(over) - MOST_TRACKS, 0)
        self.forgotten = frozenset([*over, *rest[:too_many]])
        for number in self.forgotten:
            del self._tracks[number], self._lives[number]

    def position(self, number: int) -> NDArray[np.float64] | None:
        """Where an object was last seen, world frame, metres; None if it never was or
        is forgotten."""
        track = self._tracks.get(number)
        return None if track is None else track.position


def _track(
    image: NDArray[np.uint8],
    found: Detections,
    row: int,
    face: Face,
    heights: Relief,
    camera: Camera,
) -> Track:
    x1, y1, x2, y2 = (float(value) for value in found.boxes[row])
    depth = float(found.depths[row])
    middle = ((x1 + x2) / 2 * camera.width, (y1 + y2) / 2 * camera.height, depth)
    rows, columns = np.nonzero(found.labels == row + 1)
    color = image[rows, columns].mean(axis=0) + 1.0
    a, b, _ = face.cuboid.edges_m
    some = np.linspace(0, len(rows) - 1, min(len(rows), SAMPLES)).astype(np.int64)
    rows, columns = rows[some], columns[some]
    return Track(
        camera.back_project(middle),
        color[:2] / color.sum(),
        (x2 - x1) * camera.width / camera.fx * depth,
        (max(a, b), min(a, b)),
        found.boxes[row],
        rows,
        columns,
        heights.depth[rows, columns],
    )
