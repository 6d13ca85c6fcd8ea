"""Matches detections with true objects, for judges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Smallest intersection over union of a detection with its object.
MATCH_IOU = 0.5


def overlaps(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float64]:
    """Intersection over union `[n, m]` of boxes `[n, 4]` and `[m, 4]`; 0 for empty boxes."""
    first, second = a[:, None, :].astype(np.float64), b[None, :, :].astype(np.float64)
    edges = np.minimum(first[..., 2:], second[..., 2:]) - np.maximum(
        first[..., :2], second[..., :2]
    )
    common = np.prod(np.maximum(edges, 0.0), axis=-1)
    total = np.prod(first[..., 2:] - first[..., :2], axis=-1)
    total = total + np.prod(second[..., 2:] - second[..., :2], axis=-1) - common
    return np.divide(common, total, out=np.zeros_like(common), where=total > 0)


def match(
    found: NDArray[np.float32], true: NDArray[np.float32], least: float = MATCH_IOU
) -> NDArray[np.int64]:
    """For each detection `[n, 4]` the row of its true box `[m, 4]`, or -1.

    Greedy: pairs in descending order of overlap, each row at most once, down to `least`.
    """
    rows = np.full(len(found), -1, dtype=np.int64)
    overlap = overlaps(found, true)
    while overlap.size and overlap.max() >= max(least, np.finfo(np.float64).tiny):
        row, column = np.unravel_index(np.argmax(overlap), overlap.shape)
        rows[row] = column
        overlap[row, :] = -1.0
        overlap[:, column] = -1.0
    return rows
