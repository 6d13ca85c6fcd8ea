"""Detects objects in a colour and a depth image: their boxes and depths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from nsrm import MAX_OBJECTS
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import MIN_VISIBLE_PX, Camera
from nsrm_harness.perception.cuts import slabs
from nsrm_harness.perception.edges import MAX_LABELS, sharpened, without_strays
from nsrm_harness.perception.relief import PerceptionError, Relief, relief
from nsrm_harness.perception.towers import joined, towers


@dataclass(frozen=True, eq=False)
class Detections:
    """The objects of an image, from left to right.

    * `boxes`: `float32 [n, 4]`, x1, y1, x2, y2 of the visible part as fractions of
      width and height
    * `depths`: `float32 [n]`, mean depth over the visible pixels, metres
    * `labels`: `int32 [H, W]`, i + 1 where object i is visible, 0 elsewhere
    """

    boxes: NDArray[np.float32]
    depths: NDArray[np.float32]
    labels: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.boxes)


def detect(image: NDArray[np.uint8], depth: NDArray[np.float32], camera: Camera) -> Detections:
    """Finds the objects on the table. For arguments and errors see `relief` and `objects_in`."""
    return objects_in(image, relief(image, depth, camera))


def objects_in(image: NDArray[np.uint8], seen: Relief) -> Detections:
    """Finds the objects on the table in an image whose heights are known.

    * `image`: `uint8 [H, W, 3]`

    Raises `PerceptionError` for more than `MAX_OBJECTS` objects.
    """
    labels = np.zeros(seen.depth.shape, dtype=np.int32)
    count = 0
    for tower in joined(towers(seen), image, seen):
        colors = image[tower.rows, tower.columns].astype(np.float32) + 1.0
        chroma = colors[:, :2] / colors.sum(axis=1, keepdims=True)
        slab = slabs(tower, chroma, seen.noise_m if seen.noisy else 0.0)
        labels[tower.rows, tower.columns] = count + 1 + slab
        count += int(slab.max()) + 1
    if not seen.noisy:
        return _detections(labels, seen.depth)
    _check_room(count, MAX_LABELS)
    # Pixels added by colour are beyond the rough edge of the depth image, where the depth may be
    # that of the background.
    measured = np.where(labels > 0, seen.measured, np.float32(0.0))
    return _detections(without_strays(sharpened(image, labels)), measured)


def _detections(labels: NDArray[np.int32], depth: NDArray[np.float32]) -> Detections:
    """Boxes and depths of the labels with enough pixels, renumbered."""
    height, width = labels.shape
    rows, columns = np.nonzero(labels)
    label = labels[rows, columns]
    sizes = np.bincount(label, minlength=1)
    order = np.argsort(label, kind="stable")
    pixels = []
    for own in np.split(order, np.cumsum(sizes)[:-1]):
        if len(own) >= MIN_VISIBLE_PX and (depth[rows[own], columns[own]] > 0).any():
            pixels.append((rows[own], columns[own]))
    _check_room(len(pixels), MAX_OBJECTS)
    pixels.sort(key=lambda own: (int(own[1].min()), int(own[0].min())))
    numbered = np.zeros_like(labels)
    boxes = np.zeros((len(pixels), 4), dtype=np.float32)
    depths = np.zeros(len(pixels), dtype=np.float32)
    for row, (own_rows, own_columns) in enumerate(pixels):
        numbered[own_rows, own_columns] = row + 1
        boxes[row] = (
            own_columns.min() / width,
            own_rows.min() / height,
            (own_columns.max() + 1) / width,
            (own_rows.max() + 1) / height,
        )
        values = depth[own_rows, own_columns]
        depths[row] = values[values > 0].mean(dtype=np.float64)
    return Detections(boxes, depths, numbered)


def _check_room(objects: int, room: int) -> None:
    if objects > room:
        raise PerceptionError(
            f"{objects} objects in view, at most {MAX_OBJECTS} are supported: clear the table"
        )
