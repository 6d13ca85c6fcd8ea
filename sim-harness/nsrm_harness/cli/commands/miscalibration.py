"""``harness miscalibration``: measures how many miscalibrations the core detects."""

from __future__ import annotations

from pathlib import Path

import click
from tqdm import tqdm

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import domain_option, model_option, quiet_option, seed_option
from nsrm_harness.common.json_text import json_text


@click.command("miscalibration")
@model_option
@domain_option
@click.option(
    "--count",
    type=click.IntRange(1),
    default=500,
    show_default=True,
    help="Number of scenes of each kind.",
)
@seed_option
@quiet_option
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def command(
    model_path: Path | None,
    domain_path: Path,
    count: int,
    seed: int,
    quiet: bool,
    as_json: bool,
) -> None:
    """Give the core scenes with a correctly calibrated camera, and with faults in the calibration;
    count the refusals."""
    from nsrm_harness.evaluation.metrics import load_model
    from nsrm_harness.evaluation.miscalibration.measure import measure
    from nsrm_harness.evaluation.miscalibration.scenes import KINDS

    model, domain = load_model(model_path), domains.load(domain_path)
    hidden = True if quiet or as_json else None
    with tqdm(total=count * len(KINDS), unit="scene", disable=hidden) as bar:
        found = measure(model, domain, count, seed, report=bar.update)
    click.echo(json_text(found.as_json(), indent=2) if as_json else str(found))
