"""What the core sees of an episode: the picture, the camera, and the objects that the
simulator's mask or the detector finds in it."""

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
"""Where the boxes come from: the simulator's segmentation mask, or the detector."""

CHUNK = 256
"""Episodes whose crops are in memory at a time, 20 MB of them."""


@dataclass(frozen=True, eq=False)
class Objects:
    """What is found in a picture; the core knows row i as id i + 1.

    * `boxes`: `float32 [n, 4]`, x1, y1, x2, y2 as fractions of width and height
    * `depths`: `float32 [n]`, mean depth, metres
    """

    boxes: NDArray[np.float32]
    depths: NDArray[np.float32]


def objects_of(demonstrations: Demonstrations, index: int, boxes: Boxes) -> Objects:
    """The objects of an initial scene.

    With the mask, row i is the episode's block with id i + 1. With the detector nothing
    but colour, depth and camera are looked at, and rows go from left to right; raises
    `PerceptionError`.
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
    """The initial scene of an episode as the core sees it."""
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
