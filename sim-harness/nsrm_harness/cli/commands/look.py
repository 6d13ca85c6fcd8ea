"""``harness look``: draws an episode for people, with the names of blocks and steps from its ground
truth."""

from __future__ import annotations

from pathlib import Path

import click

from nsrm_harness.data.demonstrator import describe
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.visualization.illustrate import draw_episode


@click.command("look")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("index", type=click.IntRange(0))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="out/FILE-INDEX.png",
    help="Picture to write.",
)
def command(file: Path, index: int, out: Path | None) -> None:
    """Draw episode INDEX (counted from 0) of FILE: before, after, boxes, sentence."""
    with Demonstrations(file) as demonstrations, GroundTruth(file) as judge:
        truth = judge.truth(index)
        picture = draw_episode(demonstrations, truth, index)
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
    click.echo(f"rejected attempts before it: {describe(truth.rejected)}")
    click.echo(path)
