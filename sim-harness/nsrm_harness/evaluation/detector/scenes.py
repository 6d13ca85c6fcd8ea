"""Images with known boxes, for measuring a detector."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.data.demonstrator import Demonstrator, EpisodeRequest
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.programs import Descriptions
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.simulation.render import open_renderer
from nsrm_harness.simulation.world import World

#: Smallest and largest number of blocks in a scene after a program.
OBJECTS = (4, 6)


@dataclass(frozen=True, eq=False)
class Picture:
    """The input of a detector, and its expected output; n blocks are in view.

    * `image`: `uint8 [H, W, 3]`; `depth`: `float32 [H, W]`, metres
    * `boxes`: `float32 [n, 4]`, `depths`: `float32 [n]`, both from the mask
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32]
    camera: Camera
    boxes: NDArray[np.float32]
    depths: NDArray[np.float32]


def of_file(path: Path) -> Iterator[Picture]:
    """The initial scenes of an episode file; raises `EpisodeFileError`."""
    with Demonstrations(path) as demonstrations:
        for index, count in enumerate(demonstrations.object_count):
            yield Picture(
                demonstrations.initial_image(index),
                demonstrations.initial_depth(index),
                demonstrations.camera(index),
                demonstrations.initial_boxes[index, :count],
                demonstrations.initial_depths[index, :count],
            )


def after_programs(
    domain: Domain, steps: tuple[int, int], count: int, seed: int, renderer: str = "auto"
) -> Iterator[Picture]:
    """Scenes after programs, with stacks and partly hidden blocks.

    * `steps`: smallest and largest number of steps; each is equally frequent
    """
    least, most = steps
    with closing(open_renderer(renderer)) as drawing, World() as world:
        demonstrator = Demonstrator(domain, world, drawing)
        for index in range(count):
            wanted = EpisodeRequest(least + index % (most - least + 1), OBJECTS, Descriptions(1, 2))
            episode = demonstrator.episode(generator(seed, "perception", index), wanted)
            seen = episode.final_picture
            yield Picture(seen.rgb, seen.depth, episode.camera, seen.boxes, seen.depths)


def with_noise(
    pictures: Iterable[Picture], noise_m: float, dropout: float, seed: int
) -> Iterator[Picture]:
    """The same images with white noise of standard deviation `noise_m` on depth, and a share
    `dropout` of the pixels without depth (0)."""
    for index, picture in enumerate(pictures):
        rng = generator(seed, "depth_noise", index)
        depth = picture.depth + rng.normal(0.0, noise_m, picture.depth.shape)
        depth[rng.random(depth.shape) < dropout] = 0.0
        yield replace(picture, depth=depth.astype(np.float32))
