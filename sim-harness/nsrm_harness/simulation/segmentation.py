"""Boxes and depths from the renderer's segmentation mask, as a substitute for a detector."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import MIN_VISIBLE_PX, Camera
from nsrm_harness.simulation.render import Frame, Light, Renderer, Surfaces
from nsrm_harness.simulation.world import World


@dataclass(frozen=True, eq=False)
class SegmentedObjects:
    """The visible blocks, as from a detector.

    * `ids`: ids of the visible blocks, ascending; hidden blocks are missing
    * `boxes`: `float32 [N, 4]`, x1, y1, x2, y2 as fractions of width and height
    * `depths`: `float32 [N]`, mean depth over the block's visible pixels, metres
    """

    ids: tuple[int, ...]
    boxes: NDArray[np.float32]
    depths: NDArray[np.float32]

    def location(self, block_id: int) -> NDArray[np.float32]:
        """Box corners and mean depth `[5]` of a visible block."""
        row = self.ids.index(block_id)
        return np.append(self.boxes[row], self.depths[row])


@dataclass(frozen=True, eq=False)
class SegmentedImage(SegmentedObjects):
    """The output of a camera with a detector: no ground truth except the boxes' ids.

    * `rgb`: `uint8 [H, W, 3]`; `depth`: `float32 [H, W]`, metres along the optical axis
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]


def render_segmented(
    renderer: Renderer, world: World, camera: Camera, light: Light
) -> SegmentedImage:
    """Renders an image and reads boxes and depths from its segmentation mask."""
    return segmented_image(renderer.render(world, camera, light))


def segmented_image(frame: Frame) -> SegmentedImage:
    """The visible blocks in a rendered image."""
    found = segmented_objects(frame)
    return SegmentedImage(found.ids, found.boxes, found.depths, frame.rgb, frame.depth)


def render_objects(renderer: Renderer, world: World, camera: Camera) -> SegmentedObjects:
    """Like `render_segmented`, without colours."""
    return segmented_objects(renderer.surfaces(world, camera))


def segmented_objects(seen: Surfaces) -> SegmentedObjects:
    """Boxes and mean depths of the ids in the mask."""
    depth, mask = seen.depth, seen.mask
    height, width = mask.shape
    # NumPy finds nonzero booleans several times as fast as nonzero integers.
    pixels = np.flatnonzero(mask != 0)
    rows, columns = np.divmod(pixels, width)
    found = mask.ravel()[pixels]
    values = depth.ravel()[pixels].astype(np.float64)
    ids, boxes, depths = [], [], []
    for block_id in np.unique(found):
        own = found == block_id
        if np.count_nonzero(own) < MIN_VISIBLE_PX:
            continue
        x, y = columns[own], rows[own]
        ids.append(int(block_id))
        boxes.append(
            (x.min() / width, y.min() / height, (x.max() + 1) / width, (y.max() + 1) / height)
        )
        depths.append(values[own].mean())
    return SegmentedObjects(
        tuple(ids),
        np.array(boxes, dtype=np.float32).reshape(-1, 4),
        np.array(depths, dtype=np.float32),
    )
