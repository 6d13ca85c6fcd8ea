"""Observes a scene with camera, detector and model. The caller passes in the source of images."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace

import nsrm
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.perception.camera_source import CameraSource
from nsrm_harness.perception.cuboids import Cuboids, faces
from nsrm_harness.perception.detector import objects_in
from nsrm_harness.perception.relief import PerceptionError, relief
from nsrm_harness.perception.tracking import Tracker

DARK = 8.0
"""An image whose mean brightness, of 255, is below this counts as dark."""

STAYED_M = 0.005
"""An object seen within this distance of where it was has not been moved."""
WHOLE = 0.95
"""An object that shows a smaller share of the pixels that it had at the same place is covered."""
WHOLE_ELSEWHERE = 0.75
"""The same at another place, where it is seen from another side."""

Location = NDArray[np.float32]
"""x1, y1, x2, y2 as fractions of the image, mean depth in metres."""


@dataclass(frozen=True, eq=False)
class Observation:
    """One image and the objects found in it.

    * `rgb`: `uint8 [H, W, 3]`; `depth`: `float32 [H, W]`, metres along the optical axis
    * `labels`: `int32 [H, W]`, an object's number where it is visible
    * `locations`: locations of the visible parts, by number; an object has the same number in all
      images
    * `whole`: locations of the whole objects, hidden ones included; of a covered one, as it was
      seen before, or its visible part if it was moved to where it is covered
    * `covered`: the numbers of the covered objects
    * `cuboids`: cuboids of all objects that are assumed to exist, hidden ones included
    * `taken_s`: when the image was taken, by the world's clock
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    labels: NDArray[np.int32]
    locations: Mapping[int, Location]
    whole: Mapping[int, Location]
    covered: frozenset[int]
    cuboids: Mapping[int, Cuboid]
    taken_s: float

    def scene(self, model: nsrm.Model, camera: Camera) -> nsrm.Scene:
        """The scene in which the model plans."""
        locations = np.array([*self.locations.values()], np.float32).reshape(-1, 5)
        return model.observe(
            self.rgb,
            list(self.locations),
            np.ascontiguousarray(locations[:, :4]),
            np.ascontiguousarray(locations[:, 4]),
            nsrm.Camera(**asdict(camera)),
        )


@dataclass(frozen=True, eq=False)
class _Whole:
    """An object where it was last seen; `size`: the number of pixels that it shows there if
    nothing covers it."""

    location: Location
    pose: Pose
    size: int


class DarkImageError(PerceptionError):
    """An image that is too dark."""


class Observer:
    """Observes a scene through one camera: tracks the objects and their cuboids across images."""

    def __init__(self, source: CameraSource) -> None:
        self._source = source
        self._tracker, self._cuboids = Tracker(), Cuboids(source.camera)
        self._wholes: dict[int, _Whole] = {}

    @property
    def camera(self) -> Camera:
        """The camera's calibration."""
        return self._source.camera

    @property
    def now_s(self) -> float:
        """The time, by the clock that stamps images."""
        return self._source.now_s

    def look(self, held: Collection[int] = ()) -> Observation:
        """Takes an image and finds its objects. Raises `DarkImageError` or another
        `PerceptionError`.

        * `held`: the numbers of objects that the hand may hold, which are not expected on the table
        """
        image = self._source.take()
        if image.rgb.mean() < DARK:
            raise DarkImageError("the camera's image is dark")
        heights = relief(image.rgb, image.depth, self.camera)
        found = objects_in(image.rgb, heights)
        seen = faces(found, heights, self.camera)
        numbers = self._tracker.update(image.rgb, found, seen, heights, self.camera, held)
        self._cuboids.forget(self._tracker.forgotten)
        for number in self._tracker.forgotten:
            self._wholes.pop(number, None)
        cuboids = self._cuboids.update(dict(zip(numbers, seen, strict=True)), heights)
        rows = np.column_stack([found.boxes, found.depths])
        locations = dict(zip(numbers, rows, strict=True))
        sizes = np.bincount(found.labels.ravel(), minlength=len(found) + 1)[1:].tolist()
        covered = frozenset(
            number
            for (number, location), size in zip(locations.items(), sizes, strict=True)
            if not self._is_whole(number, _Whole(location, cuboids[number].pose, size))
        )
        # Where nothing is seen that would be behind it.
        hidden = cuboids.keys() & self._wholes.keys() - locations.keys()
        return Observation(
            image.rgb,
            image.depth,
            np.array((0, *numbers), np.int32)[found.labels],
            locations,
            {number: self._wholes[number].location for number in (*locations, *sorted(hidden))},
            covered | hidden,
            cuboids,
            image.taken_s,
        )

    def _is_whole(self, number: int, now: _Whole) -> bool:
        """Whether as much of an object is visible as ever at its place, or as is expected at a new
        one; remembers what it shows if whole."""
        before = self._wholes.get(number)
        if before is None:
            self._wholes[number] = now
            return True
        if before.pose.distance_m(now.pose) < STAYED_M:
            if now.size < WHOLE * before.size:
                return False
            self._wholes[number] = replace(now, size=max(now.size, before.size))
            return True
        expected = before.size * float(before.location[4] / now.location[4]) ** 2
        is_whole = now.size >= WHOLE_ELSEWHERE * expected
        self._wholes[number] = now if is_whole else replace(now, size=round(expected))
        return is_whole


@dataclass(frozen=True)
class ObjectNames:
    """The model's names for the objects, by number.

    * `words`: the most likely value of each attribute type
    * `colors`: red, green and blue of the most likely colour, in 0..1
    """

    words: Mapping[int, str]
    colors: Mapping[int, tuple[float, float, float]]

    def spoken(self, number: int) -> str:
        """A unique name of an object; a new object has no words."""
        words = self.words.get(number)
        return f"object {number} ({words})" if words else f"object {number}"


def name_objects(model: nsrm.Model, domain: Domain, sight: Observation) -> ObjectNames:
    """Names the objects by the model's attributes."""
    words: dict[int, str] = {}
    colors: dict[int, tuple[float, float, float]] = {}
    for number, location in sight.locations.items():
        similarities = model.similarities(model.encode_crop(nsrm.crop(sight.rgb, location[:4])))
        values = [
            max(attribute.values, key=lambda value: similarities[value.name])
            for attribute in domain.attributes
        ]
        words[number] = " ".join(value.name for value in reversed(values))
        colors[number] = next(value.rgb for value in values if value.rgb is not None)
    return ObjectNames(words, colors)


def sub_goal(step: nsrm.PlannedStep) -> Pose:
    """The target pose of the centre of a step's object."""
    x, y, z = (float(value) for value in step.position)
    i, j, k, w = (float(value) for value in step.orientation)
    return Pose((x, y, z), (i, j, k, w))
