"""Reads the part of an episode file for learning: the initial scene, the sentence and the final
scene.

An HDF5 file has N episodes with at most M blocks each; row i of a scene's arrays is the block with
id i + 1, and rows past an episode's count are 0.

* ``/initial/rgb [N, H, W, 3]`` uint8, ``/initial/boxes [N, M, 4]`` float32 (x1, y1,
  x2, y2 as fractions of width and height), ``/initial/depths [N, M]`` float32 (metres)
* ``/initial/depth [N, H, W]`` uint16: along the optical axis, in units of 0.1 mm, 0
  where nothing was measured
* ``/final/…``: the same as the first three; the images, which are for people, are optional
* ``/count [N]`` uint8: number of blocks
* ``/sentence [N]`` UTF-8
* ``/camera [N, 11]`` float32: fx, fy, cx, cy, position x, y, z, orientation x, y, z, w

`writer` also writes the ground truth for judges, which only `ground_truth` reads.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import EpisodeFileError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.geometry.camera import Camera

SCHEMA = 2
#: Value of the attribute ``kind`` of a finished episode file.
KIND = "nsrm episodes"
#: Unit of ``/initial/depth``, metres.
DEPTH_UNIT_M = 1e-4
#: The images of final scenes, which are optional.
FINAL_IMAGE = "final/rgb"
#: Everything else that `Demonstrations` opens.
OBSERVED = (
    "initial/rgb",
    "initial/depth",
    "initial/boxes",
    "initial/depths",
    "final/boxes",
    "final/depths",
    "count",
    "sentence",
    "camera",
)


class Demonstrations:
    """The demonstrations of a file, without their ground truth. A context manager.

    Boxes, depths, counts, sentences and cameras are in memory; images are read on demand.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        file = open_checked(self.path)
        try:
            self._rgb = _dataset(file, "initial/rgb")
            self._final_rgb = _dataset(file, FINAL_IMAGE) if FINAL_IMAGE in file else None
            self._depth = _dataset(file, "initial/depth")
            #: The domain in the file.
            self.domain = domains.from_json(str(file.attrs["domain"]), str(path))
            #: ``train``, ``validation``, …
            self.split = str(file.attrs["split"])
            #: How the episodes were made.
            self.settings: dict[str, Any] = json.loads(str(file.attrs["settings"]))
            #: Number of blocks of each episode, uint8 ``[N]``.
            self.object_count: NDArray[np.uint8] = _dataset(file, "count")[:]
            self.sentences: list[str] = list(_dataset(file, "sentence").asstr()[:])
            #: float32 ``[N, M, 4]``
            self.initial_boxes: NDArray[np.float32] = _dataset(file, "initial/boxes")[:]
            #: float32 ``[N, M]``
            self.initial_depths: NDArray[np.float32] = _dataset(file, "initial/depths")[:]
            self.final_boxes: NDArray[np.float32] = _dataset(file, "final/boxes")[:]
            self.final_depths: NDArray[np.float32] = _dataset(file, "final/depths")[:]
            #: float32 ``[N, 11]``
            self.cameras: NDArray[np.float32] = _dataset(file, "camera")[:]
        except Exception:
            file.close()
            raise

    def __len__(self) -> int:
        return len(self.sentences)

    def __enter__(self) -> Demonstrations:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Closes the file; the data in memory stays available."""
        if self._rgb:
            self._rgb.file.close()

    def initial_image(self, index: int) -> NDArray[np.uint8]:
        """The image of the initial scene, uint8 ``[H, W, 3]``."""
        return self._rgb[index]

    def final_image(self, index: int) -> NDArray[np.uint8] | None:
        """The image of the final scene, uint8 ``[H, W, 3]``, if the file has it."""
        return None if self._final_rgb is None else self._final_rgb[index]

    def initial_depth(self, index: int) -> NDArray[np.float32]:
        """The depth image of the initial scene, float32 ``[H, W]``: metres along the
        optical axis, 0 where nothing was measured. The detector's input."""
        return depth_from_units(self._depth[index])

    def camera(self, index: int) -> Camera:
        """The camera of an episode."""
        _, height, width, _ = self._rgb.shape
        return camera_from_row(self.cameras[index], width, height)

    def only_camera(self) -> Camera:
        """The camera of all episodes. Raises ``EpisodeFileError`` if there are several: the action
        simulator learns in the image of one."""
        if (self.cameras != self.cameras[0]).any():
            raise EpisodeFileError(
                f"{self.path}: the episodes were seen by several cameras, but the simulator learns "
                "in the image of one: generate all episodes with the same camera"
            )
        return self.camera(0)

    def data_hash(self) -> str:
        """SHA-256 in hex of all observed data; it does not depend on compression or on anything
        else in the file."""
        digest = hashlib.sha256()
        for array in (
            self.object_count,
            self.initial_boxes,
            self.initial_depths,
            self.final_boxes,
            self.final_depths,
            self.cameras,
        ):
            digest.update(f"{array.dtype.str}{array.shape}".encode())
            digest.update(array.tobytes())
        digest.update(json_text(self.sentences, ensure_ascii=False).encode())
        for index in range(len(self)):
            digest.update(self.initial_image(index).tobytes())
            if (final := self.final_image(index)) is not None:
                digest.update(final.tobytes())
            digest.update(self._depth[index].tobytes())
        return digest.hexdigest()


def open_checked(path: Path) -> h5py.File:
    """Opens a finished episode file. Raises ``EpisodeFileError`` with the problem."""
    if not path.exists():
        raise EpisodeFileError(f"{path}: no such episode file: create it with 'harness episodes'")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise EpisodeFileError(f"{path}: not an episode file: {error}") from error
    try:
        if file.attrs.get("kind") != KIND:
            raise EpisodeFileError(f"{path}: not an episode file: no attribute kind = {KIND!r}")
        if (schema := int(str(file.attrs["schema"]))) != SCHEMA:
            raise EpisodeFileError(
                f"{path}: schema {schema}, this version reads {SCHEMA}: generate the file again"
            )
        settings = json.loads(str(file.attrs["settings"]))
        pictured = (FINAL_IMAGE,) if settings.get("final_image", True) else ()
        for name in (*OBSERVED, *pictured):
            if name not in file:
                raise EpisodeFileError(f"{path}: damaged: no dataset {name!r}")
    except Exception:
        file.close()
        raise
    return file


def camera_row(camera: Camera) -> NDArray[np.float32]:
    """A camera as a row of ``/camera``."""
    return np.array(
        [camera.fx, camera.fy, camera.cx, camera.cy, *camera.position, *camera.orientation],
        dtype=np.float32,
    )


def camera_from_row(row: NDArray[np.float32], width: int, height: int) -> Camera:
    """The inverse of `camera_row`."""
    fx, fy, cx, cy, x, y, z, qx, qy, qz, qw = (float(value) for value in row)
    return Camera(width, height, fx, fy, cx, cy, (x, y, z), (qx, qy, qz, qw))


def depth_units(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Converts depths in metres to stored units; values not finite or out of range become 0."""
    units = np.rint(depth / np.float32(DEPTH_UNIT_M))
    known = np.isfinite(units) & (units > 0) & (units <= np.iinfo(np.uint16).max)
    return np.where(known, units, 0).astype(np.uint16)


def depth_from_units(units: NDArray[np.uint16]) -> NDArray[np.float32]:
    """The inverse of `depth_units`, to half a unit."""
    return units.astype(np.float32) * np.float32(DEPTH_UNIT_M)


def _dataset(file: h5py.File, name: str) -> Any:
    if name not in (*OBSERVED, FINAL_IMAGE):
        raise KeyError(f"{name!r} is not a dataset for learning")
    return file[name]
