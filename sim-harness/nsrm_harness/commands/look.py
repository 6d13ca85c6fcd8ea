"""``harness look``: a picture of an episode, for people. A judge's tool: the names of
the blocks and the steps come from the truth about the episode."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
from PIL import Image

from nsrm_harness.domain import Domain
from nsrm_harness.episodes.demonstrator import describe
from nsrm_harness.episodes.file import Demonstrations
from nsrm_harness.judge import Judge, Truth
from nsrm_harness.pictures import Arrow, BoxMark, annotate, side_by_side
from nsrm_harness.world.blocks import block_from_attributes


@click.command("look")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("index", type=click.IntRange(0))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="out/FILE-INDEX.png",
    help="The picture to write.",
)
def command(file: Path, index: int, out: Path | None) -> None:
    """Draw episode INDEX (counted from 0) of FILE: before, after, boxes, sentence."""
    with Demonstrations(file) as demonstrations, Judge(file) as judge:
        truth = judge.truth(index)
        picture = draw(demonstrations, truth, index)
        sentence = demonstrations.sentences[index]
    path = out or Path("out") / f"{file.stem}-{index}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(path)
    click.echo(sentence)
    for number, step in enumerate(truth.steps, start=1):
        click.echo(
            f"{number}. {step.step.action}: {step.object_id} {truth.name(step.object_id)}, "
            f"reference {step.reference_id} {truth.name(step.reference_id)}"
        )
    click.echo(f"attempts left out before it: {describe(truth.rejected)}")
    click.echo(path)


def draw(demonstrations: Demonstrations, truth: Truth, index: int) -> Image.Image:
    """Before and after side by side; arrows from where blocks are taken to where they stay."""
    names = _names(demonstrations.domain, truth)
    before = demonstrations.initial_boxes[index]
    after = demonstrations.final_boxes[index]
    arrows: list[Arrow] = []
    standing = {block_id: _rect(before[block_id - 1]) for block_id in names}
    for number, step in enumerate(truth.steps, start=1):
        end = _rect(step.location)
        arrows.append(Arrow(standing[step.object_id], end, number))
        standing[step.object_id] = end
    left = annotate(
        demonstrations.initial_image(index),
        _marks(names, before, truth),
        arrows,
        caption=f"“{demonstrations.sentences[index]}”",
    )
    right = annotate(
        demonstrations.final_image(index),
        _marks(names, after, truth),
        caption="\n".join(
            f"{number}. {step.step.action}: {truth.name(step.object_id)}; "
            f"reference: {truth.name(step.reference_id)}"
            for number, step in enumerate(truth.steps, start=1)
        ),
    )
    title = f"{demonstrations.path.name}, episode {index}"
    return side_by_side([left, right], [f"{title}: before", "after"])


Names = dict[int, tuple[str, tuple[float, float, float]]]


def _names(domain: Domain, truth: Truth) -> Names:
    """Label and colour of each block by id."""
    return {
        block_id: (
            f"{block_id} {truth.name(block_id)}",
            block_from_attributes(domain, values).rgb,
        )
        for block_id, values in enumerate(truth.attributes, start=1)
    }


def _marks(names: Names, boxes: np.ndarray, truth: Truth) -> Sequence[BoxMark]:
    steps = list(enumerate(truth.steps, start=1))
    return [
        BoxMark(
            _rect(boxes[block_id - 1]),
            label,
            rgb,
            tuple(number for number, step in steps if step.object_id == block_id),
            tuple(number for number, step in steps if step.reference_id == block_id),
        )
        for block_id, (label, rgb) in names.items()
    ]


def _rect(box: np.ndarray) -> tuple[float, float, float, float]:
    x1, y1, x2, y2 = (float(value) for value in box[:4])
    return (x1, y1, x2, y2)
