"""``harness evaluate``: evaluates a model on an episode file with the paper's metrics."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from nsrm_harness.cli.commands.options import model_option
from nsrm_harness.common.json_text import json_text

if TYPE_CHECKING:
    from nsrm_harness.evaluation.observed import Boxes


@click.command("evaluate")
@model_option
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
    help="Source of the boxes: the simulator's mask, or the detector on colour and depth.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the metrics as JSON.")
def command(model_path: Path | None, data: Path, boxes: Boxes, as_json: bool) -> None:
    """Plan every episode of a file with the core and judge the plans."""
    from nsrm_harness.evaluation.metrics import Pace, evaluate, load_model

    pace = Pace()
    metrics = evaluate(load_model(model_path), data, boxes, quiet=as_json, pace=pace)
    click.echo(json_text(metrics.as_json(), indent=2) if as_json else f"{metrics}\n{pace}")
