"""Draws the scene that the model predicts: each object's own pixels, moved to the box from the
action simulator."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from nsrm_harness.perception.observer import Location, Observation


def cut_out(sight: Observation, number: int) -> Image.Image:
    """The pixels of an object inside its box, transparent around it."""
    height, width = sight.labels.shape
    left, top, right, bottom = (
        round(float(value) * size)
        for value, size in zip(
            sight.locations[number][:4], (width, height, width, height), strict=True
        )
    )
    rows, columns = slice(top, bottom), slice(left, right)
    opaque = np.where(sight.labels[rows, columns] == number, 255, 0).astype(np.uint8)
    return Image.fromarray(np.dstack([sight.rgb[rows, columns], opaque]))


def predicted_scene(
    background: NDArray[np.uint8],
    cutouts: Mapping[int, Image.Image],
    locations: Mapping[int, Location],
) -> NDArray[np.uint8]:
    """Draws the objects at `locations` over an empty table, the closest last.

    * `background`: `uint8 [H, W, 3]`, the same view without objects
    """
    picture = Image.fromarray(background)
    width, height = picture.size
    for object_id in sorted(locations, key=lambda key: -float(locations[key][4])):
        x1, y1, x2, y2 = (float(value) for value in locations[object_id][:4])
        left, top = round(x1 * width), round(y1 * height)
        size = (max(1, round(x2 * width) - left), max(1, round(y2 * height) - top))
        sprite = cutouts[object_id].resize(size, Image.Resampling.BILINEAR)
        picture.paste(sprite, (left, top), sprite)
    return np.asarray(picture)
