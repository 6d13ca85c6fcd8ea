"""Who is who across pictures: the detector numbers objects anew in each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.perception.detector import Detections
from nsrm_harness.world.camera import Camera

STAYED_M = 0.015
"""An object that is seen within this of where it was has not been moved."""
SAME_CHROMA = 0.06
"""Shares of red and green of two pictures of one object differ by less: light and shade
change them little, another colour by 0.15 and more."""
EDGE = 0.005
"""What is left to see of an object lies within its box, but for so much of the image."""
SAME_SIZE = 0.25
"""Widths of two pictures of one object mostly differ by less than this share,"""
ANY_SIZE = 0.5
"""and none is ever wider by more: a cube that is seen over an edge is 1.4 times as wide."""


@dataclass(frozen=True, eq=False)
class Track:
    """An object as it was seen last.

    * `position`: of the middle of its box at its mean depth, world frame, metres
    * `chroma`: `[2]`, shares of red and green in its mean colour
    * `width_m`: of its box at its mean depth
    * `box`: x1, y1, x2, y2 as fractions of the image
    """

    position: NDArray[np.float64]
    chroma: NDArray[np.float64]
    width_m: float
    box: NDArray[np.float32]

    def has_color_of(self, other: Track) -> bool:
        """Whether both may be of one colour, in whatever light."""
        return float(np.abs(self.chroma - other.chroma).max()) < SAME_CHROMA

    def looks_like(self, other: Track, size: float, within_m: float = math.inf) -> bool:
        """Whether both may be the same object.

        * `size`: by what share their widths may differ
        * `within_m`: how far apart they may be
        """
        ratio = self.width_m / other.width_m
        has_size = bool(abs(np.log(ratio)) < size)
        return has_size and self.has_color_of(other) and self.distance_m(other) <= within_m

    def is_part_of(self, other: Track) -> bool:
        """Whether this may be what is left to see of the other, where it stood."""
        low, high = self.box[:2] >= other.box[:2] - EDGE, self.box[2:] <= other.box[2:] + EDGE
        return self.has_color_of(other) and bool(low.all() and high.all())

    def shows(self, other: Track) -> bool:
        """Whether this may be the other somewhere else, of which a part may be hidden there."""
        return self.has_color_of(other) and self.width_m < other.width_m * math.exp(ANY_SIZE)

    def distance_m(self, other: Track) -> float:
        """Between where both were seen."""
        return float(np.linalg.norm(self.position - other.position))


class Tracker:
    """Gives each object one number for as long as it is there."""

    def __init__(self) -> None:
        self._tracks: dict[int, Track] = {}
        self._next = 1

    def update(
        self, image: NDArray[np.uint8], found: Detections, camera: Camera
    ) -> tuple[int, ...]:
        """The number of each object found; an object that is hidden keeps its own.

        First come those that stand where one of their looks was seen, the nearest before
        the others; then those that were moved, by their looks; then what is left to see of one
        that is hidden; at last what has the colour of one that was moved to where it is hidden in
        part. Who is left is new.
        """
        seen = [_track(image, found, row, camera) for row in range(len(found))]
        names: dict[int, int] = {}
        self._match(seen, names, lambda new, old: new.looks_like(old, SAME_SIZE, STAYED_M))
        self._match(seen, names, lambda new, old: new.looks_like(old, SAME_SIZE))
        hidden = self._match(seen, names, Track.is_part_of)
        for row in self._match(seen, names, Track.shows):
            # By the width of the whole it is known again.
            seen[row] = replace(
                seen[row], width_m=max(seen[row].width_m, self._tracks[names[row]].width_m)
            )
        for row in range(len(seen)):
            if row not in names:
                names[row] = self._next
                self._next += 1
        # One that is partly hidden is still known by its whole look.
        self._tracks |= {names[row]: track for row, track in enumerate(seen) if row not in hidden}
        return tuple(names[row] for row in range(len(seen)))

    def position(self, number: int) -> NDArray[np.float64] | None:
        """Where an object was seen last, world frame, metres; None if it never was."""
        track = self._tracks.get(number)
        return None if track is None else track.position

    def _match(
        self,
        seen: list[Track],
        names: dict[int, int],
        may_be: Callable[[Track, Track], bool],
    ) -> set[int]:
        """Gives numbers to rows that have none yet, the nearest first; which ones."""
        pairs = sorted(
            (new.distance_m(old), row, number)
            for row, new in enumerate(seen)
            for number, old in self._tracks.items()
            if row not in names and number not in names.values() and may_be(new, old)
        )
        matched: set[int] = set()
        for _, row, number in pairs:
            if row not in names and number not in names.values():
                names[row] = number
                matched.add(row)
        return matched


def _track(image: NDArray[np.uint8], found: Detections, row: int, camera: Camera) -> Track:
    x1, y1, x2, y2 = (float(value) for value in found.boxes[row])
    depth = float(found.depths[row])
    middle = ((x1 + x2) / 2 * camera.width, (y1 + y2) / 2 * camera.height, depth)
    color = image[found.labels == row + 1].mean(axis=0) + 1.0
    return Track(
        camera.back_project(middle),
        color[:2] / color.sum(),
        (x2 - x1) * camera.width / camera.fx * depth,
        found.boxes[row],
    )
