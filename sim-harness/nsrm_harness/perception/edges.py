"""Edges of objects in noisy depth, put right by colour.

A smoothed depth image has rough edges, a pixel or two wide; the colour image is sharp.
Pixels near an edge between an object and the table go to the side whose colours,
taken from a little farther in, are more like theirs.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

#: Width of the strip on each side of an edge that colour decides about, pixels.
STRIP_PX = 2
#: Edge of the square in which the two sides' colours are averaged, pixels.
WINDOW_PX = 9


def sharpened(image: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """The labels `[H, W]` with their edges towards label 0 moved to where colour
    changes, by at most `STRIP_PX`. At most 255 labels.

    * `image`: `[H, W, 3]`, in which the edges are sharp
    """
    rows, columns = np.nonzero(labels)
    if len(rows) == 0:
        return labels
    margin = WINDOW_PX + STRIP_PX
    top, left = max(0, rows.min() - margin), max(0, columns.min() - margin)
    part = np.s_[top : rows.max() + margin + 1, left : columns.max() + margin + 1]
    moved = labels.copy()
    moved[part] = _sharpened(image[part], labels[part])
    return moved


def _sharpened(image: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    small = labels.astype(np.uint8)
    objects = (small > 0).astype(np.uint8)
    square = np.ones((2 * STRIP_PX + 1, 2 * STRIP_PX + 1), dtype=np.uint8)
    grown = np.asarray(cv2.dilate(objects, square), dtype=np.uint8)
    shrunk = np.asarray(cv2.erode(objects, square), dtype=np.uint8)
    strip = (grown > 0) & (shrunk == 0)
    colors = image.astype(np.float32)
    inside = _local_mean(colors, shrunk)
    outside = _local_mean(colors, 1 - grown)
    with np.errstate(invalid="ignore"):
        own = ((colors - inside) ** 2).sum(axis=-1)
        other = ((colors - outside) ** 2).sum(axis=-1)
        keep = own < other
    decided = strip & np.isfinite(own) & np.isfinite(other)
    nearest = cv2.dilate(small, square)
    result = labels.copy()
    result[decided & ~keep] = 0
    fill = decided & keep & (labels == 0)
    result[fill] = nearest[fill]
    return result


def _local_mean(colors: NDArray[np.float32], where: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Mean colour of the pixels marked 1 around each pixel; NaN where there is none."""
    window = (WINDOW_PX, WINDOW_PX)
    marked = where.astype(np.float32)
    total = cv2.boxFilter(colors * marked[..., None], -1, window, normalize=False)
    count = cv2.boxFilter(marked, -1, window, normalize=False)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(count[..., None] > 0.5, total / count[..., None], np.nan)
