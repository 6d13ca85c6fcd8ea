"""``harness evaluate``: the paper's metrics of a model on an episode file."""

from __future__ import annotations

import json
from pathlib import Path

import click


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
@click.option("--json", "as_json", is_flag=True, help="Print the metrics as JSON.")
def command(model_path: Path | None, data: Path, as_json: bool) -> None:
    """Plan every episode of a file with the core and judge the plans."""
    import nsrm

    from nsrm_harness.evaluate import EvaluationError, evaluate

    try:
        model = nsrm.Model.load(model_path) if model_path else nsrm.Model.pretrained()
    except nsrm.ModelError as error:
        raise EvaluationError(str(error)) from error
    metrics = evaluate(model, data, quiet=as_json)
    click.echo(json.dumps(metrics.as_json(), indent=2) if as_json else str(metrics))
