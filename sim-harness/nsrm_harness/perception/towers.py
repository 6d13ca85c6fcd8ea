"""Towers: what stands on one spot of the table, one block or a stack of them.

Seen from above, blocks that don't stand on each other lie apart, however they
overlap in the picture. So the points above the table are entered into a plan, and
its connected parts are the towers.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.perception.relief import Relief
from nsrm_harness.world.camera import MIN_VISIBLE_PX

#: Edge of the plan's cells: a pixel's footprint on a flat top is about 2 mm long, and
#: a gap of twice the edge always leaves an empty cell.
CELL_M = 0.003
#: What reaches higher is no object: the arm.
CEILING_M = 0.25
#: Lower things are no objects.
MIN_HEIGHT_M = 0.015
#: Least height of a point above the table that counts, and in standard deviations.
FOREGROUND_M = 0.00015
FOREGROUND_SIGMA = 5.0
#: In noisy depth a chance row of such points may bridge two towers: only points so many
#: times higher join cells.
BODY_FACTOR = 4.0


@dataclass(frozen=True, eq=False)
class Tower:
    """The pixels of a tower: `rows`, `columns`, `height` (metres), `x`, `y` (world,
    metres), each `[n]`."""

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    height: NDArray[np.float32]
    x: NDArray[np.float32]
    y: NDArray[np.float32]


def foreground_m(relief: Relief) -> float:
    """Height from which on a point belongs to an object."""
    return max(FOREGROUND_M, FOREGROUND_SIGMA * relief.noise_m)


def towers(relief: Relief) -> list[Tower]:
    """The towers in view, in the plan's order; what reaches `CEILING_M` is left out."""
    threshold = foreground_m(relief)
    with np.errstate(invalid="ignore"):
        rows, columns = np.nonzero(relief.height > threshold)
    if len(rows) == 0:
        return []
    x, y = relief.x[rows, columns], relief.y[rows, columns]
    height = relief.height[rows, columns]
    across = ((x - x.min()) / CELL_M).astype(np.int32)
    along = ((y - y.min()) / CELL_M).astype(np.int32)
    plan = np.zeros((across.max() + 1, along.max() + 1), dtype=np.uint8)
    high = height > BODY_FACTOR * threshold if relief.noisy else np.ones_like(height, np.bool_)
    plan[across[high], along[high]] = 1
    parts, found_cells = cv2.connectedComponents(plan, connectivity=8)
    cells = np.asarray(found_cells, dtype=np.int32)
    if relief.noisy:
        # A low point goes to the tower that it stands beside, if any.
        beside = cv2.dilate(cells.astype(np.float32), np.ones((3, 3), np.uint8))
        cells = np.where(cells > 0, cells, np.asarray(beside, dtype=np.int32))
    part = cells[across, along]
    tops = np.zeros(parts, dtype=np.float32)
    np.maximum.at(tops, part, height)
    sizes = np.bincount(part, minlength=parts)
    whole = np.ones(parts, dtype=np.bool_)
    last_row, last_column = relief.depth.shape[0] - 1, relief.depth.shape[1] - 1
    border = (rows == 0) | (rows == last_row) | (columns == 0) | (columns == last_column)
    whole[part[border]] = False
    whole[0] = False
    wanted = whole & (sizes >= MIN_VISIBLE_PX) & (tops > MIN_HEIGHT_M) & (tops < CEILING_M)
    order = np.argsort(part, kind="stable")
    ends = np.cumsum(sizes)
    found = []
    for number in np.flatnonzero(wanted):
        own = order[ends[number] - sizes[number] : ends[number]]
        found.append(Tower(rows[own], columns[own], height[own], x[own], y[own]))
    return found
