"""Draws an episode as intended, or as planned by a model, for people and judges.

The names of the blocks and the steps come from the ground truth of the episode.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.domain import Domain
from nsrm_harness.simulation.blocks import block_from_attributes
from nsrm_harness.visualization.pictures import Arrow, BoxMark, Rect, annotate, side_by_side

Names = dict[int, tuple[str, tuple[float, float, float]]]
"""Label and colour of each block by id."""


class DrawnStep(Protocol):
    """The drawn part of a step, which `StepTruth` and `nsrm.PlannedStep` have."""

    @property
    def object_id(self) -> int: ...
    @property
    def reference_id(self) -> int: ...
    @property
    def location(self) -> ArrayLike: ...


def draw_episode(demonstrations: Demonstrations, truth: Truth, index: int) -> Image.Image:
    """Draws the scene before and after, side by side, with arrows for the moves of blocks.

    If the file has no images of final scenes, only the scene before is drawn.
    """
    names = _names(demonstrations.domain, truth)
    title = f"{demonstrations.path.name}, episode {index}"
    caption = f"“{demonstrations.sentences[index]}”"
    left = draw_steps(demonstrations, truth, index, truth.steps, caption)
    final = demonstrations.final_image(index)
    if final is None:
        return side_by_side([left], [f"{title}: before"])
    right = annotate(
        final,
        _marks(names, demonstrations.final_boxes[index], truth.steps),
        caption="\n".join(
            f"{number}. {step.step.action}: {truth.name(step.object_id)}; "
            f"reference: {truth.name(step.reference_id)}"
            for number, step in enumerate(truth.steps, start=1)
        ),
    )
    return side_by_side([left, right], [f"{title}: before", "after"])


def draw_steps(
    demonstrations: Demonstrations,
    truth: Truth,
    index: int,
    steps: Sequence[DrawnStep],
    caption: str,
) -> Image.Image:
    """Draws the initial scene with arrows for `steps`, the true ones or those of a plan."""
    names = _names(demonstrations.domain, truth)
    boxes = demonstrations.initial_boxes[index]
    arrows: list[Arrow] = []
    standing = {block_id: _rect(boxes[block_id - 1]) for block_id in names}
    for number, step in enumerate(steps, start=1):
        end = _rect(np.asarray(step.location))
        arrows.append(Arrow(standing[step.object_id], end, number))
        standing[step.object_id] = end
    marks = _marks(names, boxes, steps)
    return annotate(demonstrations.initial_image(index), marks, arrows, caption)


def _names(domain: Domain, truth: Truth) -> Names:
    return {
        block_id: (
            f"{block_id} {truth.name(block_id)}",
            block_from_attributes(domain, values).rgb,
        )
        for block_id, values in enumerate(truth.attributes, start=1)
    }


def _marks(names: Names, boxes: np.ndarray, steps: Sequence[DrawnStep]) -> list[BoxMark]:
    numbered = list(enumerate(steps, start=1))
    return [
        BoxMark(
            _rect(boxes[block_id - 1]),
            label,
            rgb,
            tuple(number for number, step in numbered if step.object_id == block_id),
            tuple(number for number, step in numbered if step.reference_id == block_id),
        )
        for block_id, (label, rgb) in names.items()
    ]


def _rect(box: np.ndarray) -> Rect:
    x1, y1, x2, y2 = (float(value) for value in box[:4])
    return (x1, y1, x2, y2)
