"""Who is who across pictures: the detector numbers objects anew in each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.perception.detector import Detections
from nsrm_harness.world.camera import Camera

STAYED_M = 0.015
"""An object that is seen within this of where it was has not been moved."""
SAME_CHROMA = 0.06
"""Shares of red and green of two pictures of one object differ by less: light and shade
change them little, another colour by 0.15 and more."""
SAME_SIZE = 0.25
"""Widths of two pictures of one object differ by less than this share."""


@dataclass(frozen=True, eq=False)
class Track:
    """An object as it was seen last.

    * `position`: of the middle of its box at its mean depth, world frame, metres
    * `chroma`: `[2]`, shares of red and green in its mean colour
    * `width_m`: of its box at its mean depth
    """

    position: NDArray[np.float64]
    chroma: NDArray[np.float64]
    width_m: float

    def looks_like(self, other: Track) -> bool:
        """Whether both may be the same object, wherever it stands."""
        chroma = float(np.abs(self.chroma - other.chroma).max())
        ratio = self.width_m / other.width_m
        return chroma < SAME_CHROMA and abs(np.log(ratio)) < SAME_SIZE

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
        the others; then those that were moved, by their looks. Who is left is new.
        """
        seen = [_track(image, found, row, camera) for row in range(len(found))]
        names = self._matched(seen, STAYED_M) if self._tracks else {}
        names |= self._matched(seen, float("inf"), names)
        for row in range(len(seen)):
            if row not in names:
                names[row] = self._next
                self._next += 1
        self._tracks |= {names[row]: track for row, track in enumerate(seen)}
        return tuple(names[row] for row in range(len(seen)))

    def position(self, number: int) -> NDArray[np.float64] | None:
        """Where an object was seen last, world frame, metres; None if it never was."""
        track = self._tracks.get(number)
        return None if track is None else track.position

    def _matched(
        self, seen: list[Track], within_m: float, taken: dict[int, int] | None = None
    ) -> dict[int, int]:
        taken = dict(taken or {})
        pairs = sorted(
            (track.distance_m(new), row, number)
            for row, new in enumerate(seen)
            for number, track in self._tracks.items()
            if row not in taken and number not in taken.values() and track.looks_like(new)
        )
        matched: dict[int, int] = {}
        for distance, row, number in pairs:
            if distance <= within_m and row not in matched and number not in matched.values():
                matched[row] = number
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
    )
