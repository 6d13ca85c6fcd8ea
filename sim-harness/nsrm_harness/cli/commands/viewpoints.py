"""``harness viewpoints``: measures plans through other cameras than that of the training."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import click
from tqdm import tqdm

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import model_option, quiet_option, seed_option
from nsrm_harness.common.json_text import json_text

if TYPE_CHECKING:
    import nsrm

    from nsrm_harness.geometry.camera import Camera


@click.command("viewpoints")
@model_option
@click.option(
    "--count",
    type=click.IntRange(1),
    default=200,
    show_default=True,
    help="Number of sentences for each camera.",
)
@click.option(
    "--untransformed",
    is_flag=True,
    help="Give each scene's camera as that of the training: what would happen without the "
    "transformation. Needs --model.",
)
@seed_option
@quiet_option
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def command(
    model_path: Path | None,
    count: int,
    untransformed: bool,
    seed: int,
    quiet: bool,
    as_json: bool,
) -> None:
    """Plan sentences through cameras at other places and with other images than that of the
    training; count refusals and wrong objects, and measure how far sub-goals are off."""
    from nsrm_harness.evaluation import viewpoints
    from nsrm_harness.evaluation.metrics import domain_of, load_model

    if untransformed and model_path is None:
        raise click.UsageError("--untransformed needs --model")
    model = load_model(model_path)
    domain = domain_of(model, domains.load())
    hidden = True if quiet or as_json else None
    with tqdm(total=count * len(viewpoints.VIEWS), unit="sentence", disable=hidden) as bar:
        rows = []
        for view in viewpoints.VIEWS:
            of_view = model
            if untransformed and model_path is not None and view is not None:
                of_view = _trained_through(model_path, view.camera())
            rows += viewpoints.measure(of_view, domain, count, seed, [view], report=bar.update)
    click.echo(json_text(viewpoints.as_json(rows), indent=2) if as_json else viewpoints.table(rows))


def _trained_through(path: Path, camera: Camera) -> nsrm.Model:
    """The model of a file as if this had been the camera of its training."""
    import nsrm

    from nsrm_harness.learning.export import read_model, stored, write_model

    with TemporaryDirectory() as folder:
        changed = Path(folder) / "model.safetensors"
        write_model(changed, replace(read_model(path), training_camera=stored(camera)))
        return nsrm.Model.load(changed)
