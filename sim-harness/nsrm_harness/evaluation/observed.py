"""The core's view of an episode: the image, the camera, and the objects from the simulator's mask
or the detector."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Literal

import nsrm
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from nsrm_harness.data.file import Demonstrations
from nsrm_harness.perception.detector import detect

Boxes = Literal["mask", "detector"]
"""Source of the boxes: the simulator's segmentation mask, or the detector."""

CHUNK = 256
"""Number of episodes whose crops are in memory at a time (20 MB)."""


@dataclass(frozen=True, eq=False)
class Objects:
    """The objects in an image; row i has id i + 1 in the core.

    * `boxes`: `float32 [n, 4]`, x1, y1, x2, y2 as fractions of width and height
    * `depths`: `float32 [n]`, mean depth, metres
    """

    boxes: NDArray[np.float32]
    depths: NDArray[np.float32]


def objects_of(demonstrations: Demonstrations, index: int, boxes: Boxes) -> Objects:
    """The objects of an initial scene.

    With the mask, row i is the episode's block with id i + 1. The detector uses only colour, depth
    and camera, and its rows go from left to right; it raises `PerceptionError`.
    """
    if boxes == "detector":
        found = detect(
            demonstrations.initial_image(index),
            demonstrations.initial_depth(index),
            demonstrations.camera(index),
        )
        return Objects(found.boxes, found.depths)
    count = int(demonstrations.object_count[index])
    return Objects(
        demonstrations.initial_boxes[index, :count], demonstrations.initial_depths[index, :count]
    )


def observe_episode(demonstrations: Demonstrations, index: int, objects: Objects) -> nsrm.Observed:
    """The initial scene of an episode as observed by the core."""
    return nsrm.Observed(
        demonstrations.initial_image(index),
        list(range(1, len(objects.boxes) + 1)),
        objects.boxes,
        objects.depths,
        nsrm.Camera(**asdict(demonstrations.camera(index))),
    )


def chunks(demonstrations: Demonstrations, name: str, quiet: bool) -> Iterator[range]:
    """The indices of all episodes, `CHUNK` at a time, with a progress bar."""
    count = len(demonstrations)
    with tqdm(total=count, desc=f"  {name}", disable=quiet) as progress:
        for start in range(0, count, CHUNK):
            chunk = range(start, min(start + CHUNK, count))
            yield chunk
            progress.update(len(chunk))
