"""Generates and reads calibration scenes: blocks at known poses, on the table and in stacks, and
how the camera sees them. The map from a location in the image to a position in the world is fitted
to them, separately from all episodes (section III: "a pre-learned function").

A file is HDF5; row k is one block in one scene:

* ``/locations [K, 5]`` float32: box corners as fractions, mean depth in metres
* ``/positions [K, 3]`` float64: the block's centre in the world, metres
* ``/cameras [K, 11]`` float32: as in an episode file
* attribute ``image``: height and width of the images, pixels
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import EpisodeFileError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.data.file import camera_from_row, camera_row
from nsrm_harness.data.moves import Arrangement, target
from nsrm_harness.data.programs import sample_blocks
from nsrm_harness.data.seeds import STREAMS, generator
from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.simulation.layout import LayoutError, sample_layout
from nsrm_harness.simulation.render import Light, open_renderer
from nsrm_harness.simulation.segmentation import render_segmented
from nsrm_harness.simulation.world import World

KIND = "nsrm calibration"
SCHEMA = 1
#: Smallest and largest number of blocks in a scene.
OBJECTS = (4, 6)
#: Largest number of blocks that are moved onto or beside others in a scene.
MAX_MOVES = 3


@dataclass(frozen=True, eq=False)
class Calibration:
    """The content of a calibration file: K blocks over all scenes."""

    #: float32 ``[K, 5]``
    locations: NDArray[np.float32]
    #: float64 ``[K, 3]``
    positions: NDArray[np.float64]
    cameras: tuple[Camera, ...]

    @staticmethod
    def load(path: Path | str) -> Calibration:
        """Reads a file. Raises ``EpisodeFileError`` with the problem."""
        try:
            opened = h5py.File(path, "r")
        except OSError as error:
            raise EpisodeFileError(
                f"{path}: not a calibration file: {error}; 'harness calibration' makes one"
            ) from error
        with opened:
            file: Any = opened
            if file.attrs.get("kind") != KIND or int(file.attrs["schema"]) != SCHEMA:
                raise EpisodeFileError(f"{path}: not a calibration file of schema {SCHEMA}")
            height, width = (int(edge) for edge in file.attrs["image"])
            return Calibration(
                file["locations"][:],
                file["positions"][:],
                tuple(camera_from_row(row, width, height) for row in file["cameras"][:]),
            )


def make_calibration(
    domain: Domain,
    path: Path,
    *,
    scenes: int,
    seed: int,
    renderer: str = "auto",
    report: Callable[[], object] = lambda: None,
) -> int:
    """Generates the file; calls `report` after each scene. Returns the number of rows.

    Raises `EpisodeFileError` if the file exists.
    """
    if path.exists():
        raise EpisodeFileError(f"{path}: already exists: remove it, or use another --out")
    rows: list[tuple[NDArray[np.float32], NDArray[np.float64]]] = []
    camera = default_camera()
    drawing = open_renderer(renderer)
    with World() as world:
        for index in range(scenes):
            rng = generator(seed, "calibration", index)
            _arrange(rng, domain, world)
            seen = render_segmented(drawing, world, camera, Light.sample(rng))
            known = world.poses()
            for row, block_id in enumerate(seen.ids):
                location = np.append(seen.boxes[row], seen.depths[row]).astype(np.float32)
                rows.append((location, np.array(known[block_id].position)))
            report()
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + ".unfinished")
    with h5py.File(unfinished, "w", libver=("v110", "v110")) as file:
        file["locations"] = np.stack([location for location, _ in rows])
        file["positions"] = np.stack([position for _, position in rows])
        file["cameras"] = np.tile(camera_row(camera), (len(rows), 1))
        for name, value in (
            ("kind", KIND),
            ("schema", SCHEMA),
            ("image", (camera.height, camera.width)),
            ("domain", domain.as_json()),
            ("settings", json_text({"scenes": scenes, "seed": seed, "renderer": renderer})),
            ("stream", STREAMS["calibration"]),
            ("renderer", f"{drawing.name}: {drawing.description}"),
        ):
            file.attrs[name] = value
    unfinished.replace(path)
    drawing.close()
    return len(rows)


def _arrange(rng: np.random.Generator, domain: Domain, world: World) -> None:
    """Puts blocks on the table and moves some at random; physics decides where they end.

    They stand square to the table, as at sub-goals, for which the map from a box to the world is
    used; a rotated block has a wider box.
    """
    while True:
        blocks = sample_blocks(rng, domain, int(rng.integers(OBJECTS[0], OBJECTS[1] + 1)))
        try:
            poses = sample_layout(rng, blocks, max_yaw_rad=0.0)
            break
        except LayoutError:
            continue
    world.reset()
    world.spawn(blocks, poses)
    world.settle()
    arrangement = Arrangement.on_table(blocks, poses)
    for _ in range(int(rng.integers(MAX_MOVES + 1))):
        moves = arrangement.moves(domain)
        if not moves:
            break
        move = moves[int(rng.integers(len(moves)))]
        now = [pose for _, pose in sorted(world.poses().items())]
        world.place(move.moved + 1, target(move, blocks, now))
        world.settle()
        arrangement = arrangement.after(move)
