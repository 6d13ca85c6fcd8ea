"""Cuts: the heights at which a tower changes from one block to the next.

The blocks of a tower are slabs, one above the other, so that a few heights divide all
of its pixels. They show as

* a change of colour,
* a flat top that peeps out below a block: many pixels at one height,
* an overhang: heights that are hidden below the upper block's lower edge,
* and, where a smooth wall of one colour is much higher than wide, nothing at all:
  blocks are about as high as wide.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain, pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.perception.towers import COLOR_STEP, STUDS_M, Tower

BIN_M = 0.001
#: Bins on each side of a change of colour that may be mixed.
REACH_BINS = 4
#: A bin with a smaller share of what its neighbours show says nothing about colour.
THIN_SHARE = 0.3
#: No block is lower, give or take the slack of a cut.
MIN_BLOCK_M = 0.03
SLACK_M = 0.005
#: Least number of pixels of a flat top, and how many times more than a wall shows.
MIN_TOP_PX = 25
TOP_FACTOR = 3.0
#: Least height of what an overhang hides, and the share that is still seen of it.
HIDDEN_M = 0.004
HIDDEN_SHARE = 0.35
#: A stretch of heights without a pixel, wider than the step between two rows of
#: pixels on a wall, and how far from a cut it may begin.
GAP_M = 0.0025
REACH_M = 0.006
#: Narrower footprints, for their length, show one side only.
TWO_SIDES = 0.4
#: How many standard deviations from a cut a height does not say on which side it is.
FUZZY_SIGMA = 8.0


def slabs(tower: Tower, chroma: NDArray[np.float32], noise_m: float) -> NDArray[np.int64]:
    """Which block of the tower each pixel shows, `[n]`, counted from the table.

    * `chroma`: `[n, 2]`, of the tower's pixels
    * `noise_m`: standard deviation of their heights, 0 for exact ones; near a cut
      between two colours, colour decides instead of a noisy height
    """
    levels = cuts(tower, chroma, noise_m)
    slab = np.searchsorted(levels, tower.height)
    if noise_m == 0.0:
        return slab
    reach = FUZZY_SIGMA * noise_m
    for below, level in enumerate(levels):
        lower, upper = chroma[slab == below], chroma[slab == below + 1]
        if len(lower) == 0 or len(upper) == 0:
            continue
        low, high = np.median(lower, axis=0), np.median(upper, axis=0)
        if np.linalg.norm(high - low) <= COLOR_STEP:
            continue
        near = np.flatnonzero(np.abs(tower.height - level) < reach)
        slab[near] = below + _nearer(chroma[near], high, low)
    return slab


def cuts(tower: Tower, chroma: NDArray[np.float32], noise_m: float) -> NDArray[np.float64]:
    """Heights, rising, metres: a pixel belongs to the slab number that
    `searchsorted` gives for its height.

    * `chroma`: `[n, 2]`, of the tower's pixels
    * `noise_m`: standard deviation of their heights
    """
    top = float(tower.height.max())
    if top < 2 * MIN_BLOCK_M:
        return np.empty(0)
    margin = max(0.0004, 3 * noise_m)
    bins = (tower.height / BIN_M).astype(np.int64)
    counts = np.bincount(bins, minlength=int(top / BIN_M) + 1).astype(np.float64)
    found: list[float] = []
    candidates = (
        _color_changes(tower.height, bins, counts, chroma),
        _flat_tops(tower.height, counts, margin),
        _overhangs(counts),
    )
    least = MIN_BLOCK_M - SLACK_M
    for height in chain(*candidates):
        inside = least < height < top - least
        if inside and all(abs(height - other) >= least for other in found):
            found.append(height)
    found = [_into_gap(tower.height, height) for height in found]
    found.extend(_even_parts(tower, sorted(found), top))
    return np.array(sorted(found))


def _color_changes(
    height: NDArray[np.float32],
    bins: NDArray[np.int64],
    counts: NDArray[np.float64],
    chroma: NDArray[np.float32],
) -> Iterator[float]:
    """Where the mean colour of a few millimetres above differs from that below."""
    # Between two rows of a wall lie a few pixels of its sides, which are of mixed colour.
    around = np.lib.stride_tricks.sliding_window_view(np.pad(counts, 2), 5).max(axis=1)
    seen = np.flatnonzero(counts > THIN_SHARE * around)
    if len(seen) <= 2 * REACH_BINS:
        return
    means = np.stack(
        [np.bincount(bins, chroma[:, channel])[seen] / counts[seen] for channel in range(2)],
        axis=1,
    )
    step = np.zeros(len(seen))
    step[REACH_BINS:-REACH_BINS] = np.linalg.norm(
        means[2 * REACH_BINS :] - means[: -2 * REACH_BINS], axis=1
    )
    while step[peak := int(np.argmax(step))] > COLOR_STEP:
        first, last = max(0, peak - 3 * REACH_BINS), min(len(seen) - 1, peak + 3 * REACH_BINS)
        near_low, near_high = seen[peak - REACH_BINS], seen[peak + REACH_BINS]
        low = np.median(chroma[_within(bins, seen[first], near_low)], axis=0)
        high = np.median(chroma[_within(bins, near_high, seen[last])], axis=0)
        if np.linalg.norm(high - low) > COLOR_STEP:
            between = _within(bins, near_low, near_high)
            yield _best_split(height[between], _nearer(chroma[between], high, low))
        step[first : last + 1] = 0.0


def _nearer(
    chroma: NDArray[np.float32], color: NDArray[np.float32], other: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """Which of the chromaticities `[n, 2]` are more like `color` than like `other`."""
    return np.linalg.norm(chroma - color, axis=1) < np.linalg.norm(chroma - other, axis=1)


def _within(bins: NDArray[np.int64], low: int, high: int) -> NDArray[np.bool_]:
    return (bins >= low) & (bins <= high)


def _best_split(height: NDArray[np.float32], upper: NDArray[np.bool_]) -> float:
    """The height that leaves the fewest `upper` pixels below and others above."""
    order = np.argsort(height, kind="stable")
    wrong_below = np.concatenate([[0], np.cumsum(upper[order])])
    wrong_above = np.concatenate([[0], np.cumsum(~upper[order])])
    wrong = wrong_below + (wrong_above[-1] - wrong_above)
    best = int(np.argmin(wrong))
    heights = height[order]
    low, high = heights[max(best - 1, 0)], heights[min(best, len(heights) - 1)]
    return float(low + high) / 2


def _flat_tops(
    height: NDArray[np.float32], counts: NDArray[np.float64], margin: float
) -> Iterator[float]:
    """Just above each height that shows many more pixels than the wall above it."""
    reach = round(STUDS_M / BIN_M)
    bin_number = len(counts) - 1
    while bin_number > 0:
        bin_number -= 1
        above = counts[bin_number + reach : bin_number + 4 * reach]
        above = above[above > 0]
        if len(above) < reach:
            continue
        usual = float(np.median(above))
        if counts[bin_number] < max(MIN_TOP_PX, TOP_FACTOR * usual):
            continue
        # The studs' tops, if any, are the highest bin with more than the wall shows.
        window = counts[bin_number : bin_number + reach]
        highest = bin_number + int(np.flatnonzero(window > 1.5 * usual)[-1])
        level = height[(height >= highest * BIN_M) & (height < (highest + 1) * BIN_M)]
        yield float(np.median(level)) + margin
        bin_number -= 2 * reach


def _overhangs(counts: NDArray[np.float64]) -> Iterator[float]:
    """The upper end of each stretch of heights that is hidden."""
    least = round(HIDDEN_M / BIN_M)
    for bin_number in range(len(counts) - 2 * least, 2 * least, -1):
        usual = np.median(counts[bin_number : bin_number + 3 * least])
        hidden = counts[bin_number - least : bin_number]
        if usual > 0 and hidden.max() < HIDDEN_SHARE * usual and counts[: bin_number - least].any():
            yield bin_number * BIN_M


def _into_gap(height: NDArray[np.float32], cut: float) -> float:
    """The middle of a stretch of heights near the cut that shows nothing, if there is
    one; what a cut just above it would take from the upper block is lost to it."""
    near = np.sort(height[np.abs(height - cut) < REACH_M])
    near = np.concatenate([[cut - REACH_M], near, [cut + REACH_M]])
    gaps = np.diff(near)
    widest = int(np.argmax(gaps))
    return float(near[widest] + gaps[widest] / 2) if gaps[widest] >= GAP_M else cut


def _even_parts(tower: Tower, found: list[float], top: float) -> Iterator[float]:
    """Cuts of what is much higher than wide into equal parts about as high as wide."""
    levels = [0.0, *found, top]
    for low, high in pairwise(levels):
        if high - low < 2 * MIN_BLOCK_M:
            continue
        own = (tower.height > low) & (tower.height <= high)
        points = np.stack([tower.x[own], tower.y[own]], axis=1)
        if len(points) == 0:
            continue
        width = _width_m(points)
        parts = min(round((high - low) / max(width, BIN_M)), int((high - low) / MIN_BLOCK_M))
        for number in range(1, parts):
            yield low + (high - low) * number / parts


def _width_m(points: NDArray[np.float32]) -> float:
    """Edge of a square footprint, of which the points `[n, 2]` may show one side, two
    or all. Two sides fit a square and, turned by 45°, a longer rectangle as well; their
    areas are equal."""
    short, long = sorted(cv2.minAreaRect(points)[1])
    return math.sqrt(short * long) if short > TWO_SIDES * long else long
