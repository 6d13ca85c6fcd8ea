"""Finds the cuts of a tower: the heights at which one block ends and the next begins.

The blocks of a tower are slabs, one above the other, so a few heights divide all of its pixels. A
cut shows as

* a change of colour,
* a flat top that shows below a block: many pixels at one height,
* an overhang: heights that are hidden below the lower edge of the upper block,
* or, in a smooth wall of one colour that is much higher than wide, not at all: blocks are about as
  high as wide.
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
#: A bin with a smaller share of its neighbours' pixels is ignored for colour.
THIN_SHARE = 0.3
#: Smallest height of a block, within the slack of a cut.
MIN_BLOCK_M = 0.03
SLACK_M = 0.005
#: Smallest number of pixels of a flat top, absolute and as a multiple of a wall's.
MIN_TOP_PX = 25
TOP_FACTOR = 3.0
#: Smallest height that an overhang hides, and the share of it that is still visible.
HIDDEN_M = 0.004
HIDDEN_SHARE = 0.35
#: Smallest gap of heights without a pixel, wider than the step between two rows of pixels on a
#: wall, and its largest distance from a cut.
GAP_M = 0.0025
REACH_M = 0.006
#: Footprints that are narrower, relative to their length, show only one side.
TWO_SIDES = 0.4
#: Within this many standard deviations of a cut, a height does not decide on which side it is.
FUZZY_SIGMA = 8.0


def slabs(tower: Tower, chroma: NDArray[np.float32], noise_m: float) -> NDArray[np.int64]:
    """The block of the tower that each pixel shows, `[n]`, counted from the table.

    * `chroma`: `[n, 2]`, chromaticities of the tower's pixels
    * `noise_m`: standard deviation of their heights, 0 if exact; near a cut between two colours,
      colour decides instead of a noisy height
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
    """The heights of the cuts, ascending, metres: `searchsorted` gives the slab of a pixel's
    height.

    * `chroma`: `[n, 2]`, chromaticities of the tower's pixels
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
    """Heights at which the mean colour of a few millimetres above differs from that below."""
    # Between two rows of a wall are a few pixels of its sides, with mixed colours.
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
    """Cuts just above each height that shows many more pixels than the wall above it."""
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
        # The tops of studs, if any, are the highest bin with more pixels than the wall.
        window = counts[bin_number : bin_number + reach]
        highest = bin_number + int(np.flatnonzero(window > 1.5 * usual)[-1])
        level = height[(height >= highest * BIN_M) & (height < (highest + 1) * BIN_M)]
        yield float(np.median(level)) + margin
        bin_number -= 2 * reach


def _overhangs(counts: NDArray[np.float64]) -> Iterator[float]:
    """The upper end of each hidden range of heights."""
    least = round(HIDDEN_M / BIN_M)
    for bin_number in range(len(counts) - 2 * least, 2 * least, -1):
        usual = np.median(counts[bin_number : bin_number + 3 * least])
        hidden = counts[bin_number - least : bin_number]
        if usual > 0 and hidden.max() < HIDDEN_SHARE * usual and counts[: bin_number - least].any():
            yield bin_number * BIN_M


def _into_gap(height: NDArray[np.float32], cut: float) -> float:
    """The cut moved to the middle of a nearby gap of heights without pixels, if there is one. A cut
    just above the gap would take pixels from the upper block."""
    near = np.sort(height[np.abs(height - cut) < REACH_M])
    near = np.concatenate([[cut - REACH_M], near, [cut + REACH_M]])
    gaps = np.diff(near)
    widest = int(np.argmax(gaps))
    return float(near[widest] + gaps[widest] / 2) if gaps[widest] >= GAP_M else cut


def _even_parts(tower: Tower, found: list[float], top: float) -> Iterator[float]:
    """Cuts of a part that is much higher than wide into equal parts about as high as wide."""
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
    """Edge of a square footprint of which the points `[n, 2]` show one side, two sides or
    everything. Two sides fit both a square and, rotated by 45°, a longer rectangle; their areas are
    equal."""
    short, long = sorted(cv2.minAreaRect(points)[1])
    return math.sqrt(short * long) if short > TWO_SIDES * long else long
