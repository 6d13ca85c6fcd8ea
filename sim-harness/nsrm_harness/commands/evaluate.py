"""``harness evaluate``: the paper's metrics of a model on an episode file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from nsrm_harness.observing import Boxes


@click.command("evaluate")
@click.option(
    "--model",
    "model_path",
    type=click.Path(path_type=Path),
    show_default="the one that is built in",
    help="Model file.",
)
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("data/tabletop/test.h5"),
    show_default=True,
    help="Episode file.",
)
@click.option(
    "--boxes",
    type=click.Choice(["mask", "detector"]),
    default="mask",
    show_default=True,
    help="What finds the objects: the simulator's mask, or the detector on colour and depth.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the metrics as JSON.")
def command(model_path: Path | None, data: Path, boxes: Boxes, as_json: bool) -> None:
    """Plan every episode of a file with the core and judge the plans."""
    import nsrm

    from nsrm_harness.evaluate import EvaluationError, evaluate

    try:
        model = nsrm.Model.load(model_path) if model_path else nsrm.Model.pretrained()
    except nsrm.ModelError as error:
        raise EvaluationError(str(error)) from error
    metrics = evaluate(model, data, boxes, quiet=as_json)
    click.echo(json.dumps(metrics.as_json(), indent=2) if as_json else str(metrics))
