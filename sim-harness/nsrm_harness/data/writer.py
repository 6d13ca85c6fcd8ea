"""Writes episode files: the data for learning (see `file`), and the ground truth for judges under
``/evaluation``:

* ``program [N]`` JSON: steps with action, object, reference, object_id, reference_id and
  end, the character of the sentence after the step's words
* ``attributes [N]`` JSON: each block's value of each attribute type
* ``initial_poses``, ``final_poses [N, M, 7]`` float64: x, y, z, quaternion x, y, z, w
* ``edges_m [N, M, 3]`` float64
* ``sub_goals [N, 8, 8]`` float64: index of the moved block (-1: no such step), then
  its pose at rest after the step
* ``sub_goal_boxes [N, 8, 5]`` float32: box and mean depth of that block as seen then
* ``rejected [N]`` JSON: attempts rejected before the episode, by reason

A file does not depend on when, or in how many parts, it was written.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from nsrm import MAX_STEPS

from nsrm_harness.common.json_text import json_text
from nsrm_harness.data.demonstrator import Episode
from nsrm_harness.data.file import camera_row, depth_units
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.segmentation import SegmentedImage, SegmentedObjects

#: zlib's level for images: 18 KB for one at 640×480, 2 ms; level 4 gives 12 KB in 5 ms.
COMPRESSION = 1
#: For depth, after shuffling bytes: 27 KB for one at 640×480, 1.5 ms; without shuffling 32 KB in
#: 1.7 ms, LZF with shuffling 32 KB in 1.8 ms.
DEPTH_COMPRESSION = 1
#: Datasets stored as one compressed chunk per episode.
_INITIAL_IMAGE, _FINAL_IMAGE = "initial/rgb", "final/rgb"
_DEPTHS = ("initial/depth",)
_TEXTS = ("sentence", "evaluation/program", "evaluation/attributes", "evaluation/rejected")


class EpisodeWriter:
    """Writes an episode file with a known number of episodes. A context manager.

    Images are written immediately, everything else at the end.
    """

    def __init__(
        self,
        path: Path | BytesIO,
        count: int,
        objects: int,
        image: tuple[int, int],
        final_image: bool = True,
    ) -> None:
        """`objects`: largest number of blocks in an episode; `image`: height and width, pixels;
        `final_image`: whether the images of final scenes are kept."""
        self._file = h5py.File(path, "w", libver=("v110", "v110"))
        self._images: dict[str, Any] = {}
        height, width = image
        for name in (_INITIAL_IMAGE, _FINAL_IMAGE) if final_image else (_INITIAL_IMAGE,):
            self._images[name] = self._file.create_dataset(
                name,
                (count, height, width, 3),
                np.uint8,
                chunks=(1, height, width, 3),
                compression="gzip",
                compression_opts=COMPRESSION,
            )
        for name in _DEPTHS:
            self._images[name] = self._file.create_dataset(
                name,
                (count, height, width),
                np.uint16,
                chunks=(1, height, width),
                shuffle=True,
                compression="gzip",
                compression_opts=DEPTH_COMPRESSION,
            )
        self._texts = {name: [""] * count for name in _TEXTS}
        self._tables: dict[str, np.ndarray] = {
            name: np.zeros((count, *shape), kind)
            for name, shape, kind in (
                ("initial/boxes", (objects, 4), np.float32),
                ("initial/depths", (objects,), np.float32),
                ("final/boxes", (objects, 4), np.float32),
                ("final/depths", (objects,), np.float32),
                ("count", (), np.uint8),
                ("camera", (11,), np.float32),
                ("evaluation/initial_poses", (objects, 7), np.float64),
                ("evaluation/final_poses", (objects, 7), np.float64),
                ("evaluation/edges_m", (objects, 3), np.float64),
                ("evaluation/sub_goals", (MAX_STEPS, 8), np.float64),
                ("evaluation/sub_goal_boxes", (MAX_STEPS, 5), np.float32),
            )
        }

    def __enter__(self) -> EpisodeWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._file as file:
            if error is None:
                for name, table in self._tables.items():
                    file.create_dataset(name, data=table)
                for name, texts in self._texts.items():
                    file.create_dataset(name, data=texts, dtype=h5py.string_dtype("utf-8"))

    def attributes(self, values: Mapping[str, Any]) -> None:
        """Sets attributes of the file."""
        for name, value in values.items():
            self._file.attrs[name] = value

    def write(self, row: int, episode: Episode) -> None:
        """Writes an episode to a row."""
        self._observed(row, episode)
        self._truth(row, episode)

    def copy(self, row: int, source: Mapping[str, Any]) -> int:
        """Copies all episodes of another file of the same shape to the rows from `row` on, without
        recompressing images; returns the next row."""
        end = row + len(source["count"])
        for name, images in self._images.items():
            origin = (0,) * (images.ndim - 1)
            for offset in range(end - row):
                _, chunk = source[name].id.read_direct_chunk((offset, *origin))
                images.id.write_direct_chunk((row + offset, *origin), chunk)
        for name, table in self._tables.items():
            table[row:end] = source[name][:]
        for name, texts in self._texts.items():
            texts[row:end] = source[name].asstr()[:]
        return end

    def _observed(self, row: int, episode: Episode) -> None:
        self._scene(row, "initial", episode.initial)
        self._scene(row, "final", episode.final)
        chunk = zlib.compress(_shuffled(depth_units(episode.initial.depth)), DEPTH_COMPRESSION)
        self._images["initial/depth"].id.write_direct_chunk((row, 0, 0), chunk)
        self._tables["count"][row] = len(episode.blocks)
        self._tables["camera"][row] = camera_row(episode.camera)
        self._texts["sentence"][row] = episode.sentence.text

    def _scene(self, row: int, when: str, seen: SegmentedObjects) -> None:
        name = f"{when}/rgb"
        if isinstance(seen, SegmentedImage) and name in self._images:
            chunk = zlib.compress(seen.rgb.tobytes(), COMPRESSION)
            self._images[name].id.write_direct_chunk((row, 0, 0, 0), chunk)
        blocks = np.array(seen.ids) - 1
        self._tables[f"{when}/boxes"][row, blocks] = seen.boxes
        self._tables[f"{when}/depths"][row, blocks] = seen.depths

    def _truth(self, row: int, episode: Episode) -> None:
        for name, value in (
            ("program", {"steps": _steps(episode)}),
            ("attributes", [block.values for block in episode.blocks]),
            ("rejected", dict(sorted(episode.rejected.items()))),
        ):
            self._texts[f"evaluation/{name}"][row] = json_text(value, ensure_ascii=False)
        count = len(episode.blocks)
        for name, rows in (
            ("initial_poses", _pose_rows(episode.initial_poses)),
            ("final_poses", _pose_rows(episode.final_poses)),
            ("edges_m", [block.edges_m for block in episode.blocks]),
        ):
            self._tables[f"evaluation/{name}"][row, :count] = rows
        goals = self._tables["evaluation/sub_goals"][row]
        goals[:, 0] = -1.0
        for step, goal in enumerate(episode.sub_goals):
            goals[step] = [goal.moved, *goal.pose.position, *goal.pose.orientation]
            self._tables["evaluation/sub_goal_boxes"][row, step] = goal.location


def _shuffled(units: np.ndarray) -> bytes:
    """HDF5's shuffle filter for uint16: all low bytes, then all high bytes."""
    return units.astype("<u2").view(np.uint8).reshape(-1, 2).T.tobytes()


def _steps(episode: Episode) -> list[dict[str, Any]]:
    return [
        {
            **step.as_json(),
            "object_id": goal.moved + 1,
            "reference_id": goal.reference + 1,
            "end": end,
        }
        for step, goal, end in zip(
            episode.program, episode.sub_goals, episode.sentence.ends, strict=True
        )
    ]


def _pose_rows(poses: Sequence[Pose]) -> list[list[float]]:
    return [[*pose.position, *pose.orientation] for pose in poses]
