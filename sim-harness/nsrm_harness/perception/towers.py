"""Finds towers: a block, or a stack of blocks, at one place on the table.

Seen from above, blocks that do not stand on each other are separate, however they overlap in the
image. So the points above the table are entered into a plan view, and its connected components are
the towers.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import cv2
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import MIN_VISIBLE_PX
from nsrm_harness.perception.relief import Relief

#: Edge of the plan's cells: the footprint of a pixel on a flat top is about 2 mm long, and a gap of
#: twice the edge always leaves an empty cell.
CELL_M = 0.003
#: Anything higher is not an object but the arm.
CEILING_M = 0.25
#: Anything lower is not an object.
MIN_HEIGHT_M = 0.015
#: Smallest height above the table of a point that counts, absolute and in standard deviations.
FOREGROUND_M = 0.00015
FOREGROUND_SIGMA = 5.0
#: In noisy depth, a random row of such points may bridge two towers: only points this many times
#: higher join cells.
BODY_FACTOR = 4.0
#: Height of studs: the top of a block, or the next block, may be this far above its flat top.
STUDS_M = 0.006
#: Largest height of a block of which two parts are joined.
MAX_JOINED_M = 0.06
#: Smallest distance between the chromaticities (in 0..1) of two colours.
COLOR_STEP = 0.10
#: Largest ratio of a block's longer edge to its height, and to its shorter edge.
JOINED_EDGE = 1.5


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
    """Height above which a point belongs to an object."""
    return max(FOREGROUND_M, FOREGROUND_SIGMA * relief.noise_m)


def towers(relief: Relief) -> list[Tower]:
    """The towers in view, in the plan's order, without those that reach `CEILING_M`."""
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
        # A low point belongs to the adjacent tower, if any.
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


def joined(found: list[Tower], image: NDArray[np.uint8], relief: Relief) -> list[Tower]:
    """The towers, with the parts of a block joined that a closer tower divides.

    Two parts are one block if they are equally high and of one colour, what is between
    them in the image is closer than both, and their common footprint is about square and about as
    wide as the block is high. This applies only to single blocks.

    * `image`: `[H, W, 3]`
    """
    rest = list(found)
    whole: list[Tower] = []
    while rest:
        tower = rest.pop(0)
        other = next((other for other in rest if _one_block(tower, other, image, relief)), None)
        if other is None:
            whole.append(tower)
            continue
        rest.remove(other)
        rest.insert(0, _together(tower, other))
    return whole


def _together(a: Tower, b: Tower) -> Tower:
    return Tower(*(np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(Tower)))


def _one_block(a: Tower, b: Tower, image: NDArray[np.uint8], relief: Relief) -> bool:
    tops = (float(a.height.max()), float(b.height.max()))
    if max(tops) > MAX_JOINED_M or abs(tops[0] - tops[1]) > STUDS_M + 6 * relief.noise_m:
        return False
    colors = [np.median(image[part.rows, part.columns], axis=0) + 1.0 for part in (a, b)]
    if np.linalg.norm(colors[0] / colors[0].sum() - colors[1] / colors[1].sum()) > COLOR_STEP:
        return False
    both = _together(a, b)
    short, long = sorted(cv2.minAreaRect(np.stack([both.x, both.y], axis=1))[1])
    if long > JOINED_EDGE * max(tops) or long > JOINED_EDGE * short:
        return False
    middle = [
        int((np.mean(getattr(a, axis)) + np.mean(getattr(b, axis))) / 2)
        for axis in ("rows", "columns")
    ]
    depths = relief.depth[both.rows, both.columns]
    return bool(relief.depth[middle[0], middle[1]] < depths.min())
