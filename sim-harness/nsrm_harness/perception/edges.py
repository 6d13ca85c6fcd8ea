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
#: Most labels of a picture.
MAX_LABELS = 255
#: Smaller parts of an object are noise.
SPECK_PX = 12


def sharpened(image: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """The labels `[H, W]` with their edges towards label 0 moved to where colour
    changes, by at most `STRIP_PX`; at most `MAX_LABELS` of them.

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


def without_strays(labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """The labels `[H, W]` without specks: parts of less than `SPECK_PX` pixels go to
    the neighbouring label, that of the greatest number if there are several.

    Along the edge of an upper block noise leaves pixels that seem to be the lower
    one's, and one of them is enough to widen its box.
    """
    small = labels.astype(np.uint8)
    kept = np.zeros_like(small)
    for label in range(1, int(small.max()) + 1):
        own = np.asarray(cv2.inRange(small, label, label))
        left, top, width, height = cv2.boundingRect(own)
        if width == 0:
            continue
        part = np.s_[top : top + height, left : left + width]
        _, parts, stats, _ = cv2.connectedComponentsWithStats(own[part], connectivity=8)
        large = stats[:, cv2.CC_STAT_AREA] >= SPECK_PX
        large[0] = False
        kept[part][large[parts]] = label
    speck = (small > 0) & (kept == 0)
    kept[speck] = np.asarray(cv2.dilate(kept, np.ones((3, 3), dtype=np.uint8)))[speck]
    return kept.astype(np.int32)


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
