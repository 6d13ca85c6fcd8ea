"""Tracks which other objects are displaced while one is carried, across all tries."""

from __future__ import annotations

import math
from collections.abc import Mapping

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.stability import resting_on

DISPLACED_M = 0.003
"""Another block that is seen farther than this from its previous pose has been displaced."""
COVERED_M = 0.010
"""Tolerance for a block that supports another: the upper one hides a part of it, so it may be seen
this far off, provided that the upper one has stayed where it was."""

Displacements = tuple[tuple[str, float], ...]
"""The names of the other objects that were moved, and the largest displacement of each, metres;
infinite if the object is no longer seen."""


def moved_objects(before: Mapping[int, Cuboid], now: Mapping[int, Cuboid]) -> set[int]:
    """The numbers of the objects that are seen at another place than before, or are no longer
    seen."""
    shifts_m = {
        number: now[number].pose.distance_m(cuboid.pose) if number in now else math.inf
        for number, cuboid in before.items()
    }
    stayed = {number: now[number] for number, shift_m in shifts_m.items() if shift_m <= DISPLACED_M}
    return {
        number
        for number in shifts_m.keys() - stayed.keys()
        if shifts_m[number] > COVERED_M or not resting_on(now[number], stayed)
    }


class DisplacementTracker:
    """Tracks how far each object is seen from where it was first seen, or from where it was last
    put. Between two observations a block may be pushed by less than is noticed, so comparing
    consecutive ones is not enough."""

    def __init__(self) -> None:
        self._stood: dict[str, Pose] = {}
        self._farthest_m: dict[str, float] = {}
        self._unseen: set[str] = set()

    def see(self, objects: Mapping[str, Cuboid], carried: str | None = None) -> None:
        """Records an observation of all objects that are believed to be there.

        * `carried`: the object that was to move since the previous observation
        """
        if carried is not None:
            self._stood.pop(carried, None)
        for name, cuboid in objects.items():
            shift_m = cuboid.pose.distance_m(self._stood.setdefault(name, cuboid.pose))
            self._farthest_m[name] = max(shift_m, self._farthest_m.get(name, 0.0))
        self._unseen = self._stood.keys() - objects.keys()

    def besides(self, name: str) -> Displacements:
        """The displacements of all objects except this one."""
        shifts = (
            (other, math.inf if other in self._unseen else shift_m)
            for other, shift_m in self._farthest_m.items()
            if other != name
        )
        return tuple((other, shift_m) for other, shift_m in shifts if shift_m > DISPLACED_M)


def in_words(shifted: Displacements) -> str:
    """The displacements as text to append to a message; empty if nothing has moved."""
    return "".join(
        f"; {name} was pushed by {1000 * shift_m:.1f} mm"
        if math.isfinite(shift_m)
        else f"; {name} is no longer seen"
        for name, shift_m in shifted
    )
