"""Corrects the edges of objects in noisy depth by colour.

A smoothed depth image has rough edges, a pixel or two wide; the colour image is sharp. Pixels near
an edge between an object and the table are assigned to the side whose colours, sampled a little
farther in, are more similar.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

#: Width of the strip on each side of an edge in which colour decides, pixels.
STRIP_PX = 2
#: Side of the square over which the colours of both sides are averaged, pixels.
WINDOW_PX = 9
#: Largest number of labels in an image.
MAX_LABELS = 255
#: Smaller parts of an object are noise.
SPECK_PX = 12


def sharpened(image: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """The labels `[H, W]`, at most `MAX_LABELS`, with their edges to label 0 moved to where the
    colour changes, by at most `STRIP_PX`.

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
    """The labels `[H, W]` without specks: parts with less than `SPECK_PX` pixels are merged into
    the neighbouring label, the highest one if there are several.

    Along the edge of an upper block, noise leaves pixels that seem to belong to the lower one; a
    single one of them widens its box.
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
        kept[part][large[np.asarray(parts, dtype=np.int32)]] = label
    speck = (small > 0) & (kept == 0)
    kept[speck] = np.asarray(cv2.dilate(kept, np.ones((3, 3), dtype=np.uint8)))[speck]
    return kept.astype(np.int32)


def _sharpened(image: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    small = labels.astype(np.uint8)
    objects = (small > 0).astype(np.uint8)
    square = np.ones((2 * STRIP_PX + 1, 2 * STRIP_PX + 1), dtype=np.uint8)
    grown = np.asarray(cv2.dilate(objects, square), dtype=np.uint8)
    shrunk = np.asarray(cv2.erode(objects, square), dtype=np.uint8)
    rows, columns = np.nonzero(grown > shrunk)
    own = image[rows, columns].astype(np.float32)
    to_inside = _distance(own, _local_mean(image, shrunk, rows, columns))
    to_outside = _distance(own, _local_mean(image, 1 - grown, rows, columns))
    decided = np.isfinite(to_inside) & np.isfinite(to_outside)
    rows, columns = rows[decided], columns[decided]
    inside = to_inside[decided] < to_outside[decided]
    before = labels[rows, columns]
    nearest = cv2.dilate(small, square)[rows, columns]
    result = labels.copy()
    result[rows, columns] = np.where(inside, np.where(before > 0, before, nearest), 0)
    return result


def _distance(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    """Squared distance of colours `[n, 3]`."""
    return ((a - b) ** 2).sum(axis=1)


def _local_mean(
    image: NDArray[np.uint8],
    where: NDArray[np.uint8],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Mean colour `[n, 3]` of the marked pixels around each of the n pixels; NaN if
    there are none."""
    window = (WINDOW_PX, WINDOW_PX)
    marked = cv2.bitwise_and(image, image, mask=where)
    total = cv2.boxFilter(marked, cv2.CV_32F, window, normalize=False)[rows, columns]
    count = cv2.boxFilter(where, cv2.CV_32F, window, normalize=False)[rows, columns, None]
    mean = np.full(total.shape, np.nan, dtype=np.float32)
    return np.divide(total, count, out=mean, where=count > 0.5)
