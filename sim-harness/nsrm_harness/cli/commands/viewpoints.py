"""``harness viewpoints``: measures plans through other cameras than that of the training."""

from __future__ import annotations

from pathlib import Path

import click
from tqdm import tqdm

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import model_option, quiet_option, seed_option
from nsrm_harness.common.json_text import json_text


@click.command("viewpoints")
@model_option
@click.option(
    "--count",
    type=click.IntRange(1),
    default=200,
    show_default=True,
    help="Number of sentences for each camera.",
)
@seed_option
@quiet_option
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def command(model_path: Path | None, count: int, seed: int, quiet: bool, as_json: bool) -> None:
    """Plan sentences through cameras at other places and with other images than that of the
    training; count refusals and wrong objects, and measure how far sub-goals are off."""
    from nsrm_harness.evaluation import viewpoints
    from nsrm_harness.evaluation.metrics import domain_of, load_model

    model = load_model(model_path)
    domain = domain_of(model, domains.load())
    hidden = True if quiet or as_json else None
    with tqdm(total=count * len(viewpoints.VIEWS), unit="sentence", disable=hidden) as bar:
        rows = viewpoints.measure(model, domain, count, seed, report=bar.update)
    click.echo(json_text(viewpoints.as_json(rows), indent=2) if as_json else viewpoints.table(rows))
