"""Reads the ground truth of episodes, the group ``/evaluation`` of a file, for judges.

It is the only module that does; nothing that learns or plans imports it."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import EpisodeFileError
from nsrm_harness.data.file import open_checked
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.geometry.pose import Pose


@dataclass(frozen=True, eq=False)
class StepTruth:
    """The meaning and the result of one step of the program."""

    step: Step
    object_id: int
    reference_id: int
    #: End of the step's words in the sentence, in characters.
    end: int
    #: Pose of the moved block at rest after the step, in the world.
    sub_goal: Pose
    #: Its box corners (fractions) and mean depth (metres) seen then, float32 ``[5]``.
    location: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Truth:
    """The ground truth of one episode; row i of an array is the block with id i + 1."""

    steps: tuple[StepTruth, ...]
    #: Value of each attribute type, for each block.
    attributes: tuple[dict[str, str], ...]
    #: float64 ``[n, 3]``, metres.
    edges_m: NDArray[np.float64]
    initial_poses: tuple[Pose, ...]
    final_poses: tuple[Pose, ...]
    #: Attempts rejected before this episode, by reason.
    rejected: Counter[str]

    @property
    def program(self) -> Program:
        """The intended program, without the objects."""
        return tuple(each.step for each in self.steps)

    def name(self, block_id: int) -> str:
        """A block's attribute values, the last type first: ``small green``."""
        return " ".join(reversed(self.attributes[block_id - 1].values()))


class GroundTruth:
    """The ground truth of the episodes in a file. A context manager."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._file: Any = open_checked(self.path)
        if "evaluation" not in self._file:
            self._file.close()
            raise EpisodeFileError(f"{path}: has no ground truth for evaluation")

    def __len__(self) -> int:
        return len(self._file["count"])

    def __enter__(self) -> GroundTruth:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def truth(self, index: int) -> Truth:
        """The ground truth of an episode. Raises ``EpisodeFileError`` if there is no
        such episode."""
        if not 0 <= index < len(self):
            raise EpisodeFileError(
                f"{self.path}: no episode {index}: it has {len(self)}, numbered from 0"
            )
        group = self._file["evaluation"]
        count = int(self._file["count"][index])
        steps = json.loads(group["program"].asstr()[index])["steps"]
        goals, boxes = group["sub_goals"][index], group["sub_goal_boxes"][index]
        return Truth(
            steps=tuple(
                StepTruth(
                    Step.from_json(step),
                    int(step["object_id"]),
                    int(step["reference_id"]),
                    int(step["end"]),
                    _pose(goals[number, 1:]),
                    boxes[number],
                )
                for number, step in enumerate(steps)
            ),
            attributes=tuple(json.loads(group["attributes"].asstr()[index])),
            edges_m=group["edges_m"][index, :count],
            initial_poses=tuple(_pose(row) for row in group["initial_poses"][index, :count]),
            final_poses=tuple(_pose(row) for row in group["final_poses"][index, :count]),
            rejected=Counter(json.loads(group["rejected"].asstr()[index])),
        )


def _pose(row: NDArray[np.float64]) -> Pose:
    x, y, z, qx, qy, qz, qw = (float(value) for value in row)
    return Pose((x, y, z), (qx, qy, qz, qw))
