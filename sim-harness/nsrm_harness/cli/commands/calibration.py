"""``harness calibration``: generates the file to which the camera model is fitted."""

from __future__ import annotations

from pathlib import Path

import click
from tqdm import tqdm

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import domain_option, seed_option
from nsrm_harness.data.calibration import make_calibration
from nsrm_harness.simulation.render import KINDS


@click.command("calibration")
@click.option(
    "--count", type=click.IntRange(1), default=400, show_default=True, help="Number of scenes."
)
@domain_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="data/DOMAIN/calibration.h5",
    help="File to write.",
)
@seed_option
@click.option("--renderer", type=click.Choice(KINDS), default="auto", show_default=True)
def command(count: int, domain_path: Path, out: Path | None, seed: int, renderer: str) -> None:
    """Generate the file to which the camera model is fitted: blocks at known poses."""
    domain = domains.load(domain_path)
    path = out or Path("data") / domain.name / "calibration.h5"
    with tqdm(total=count, unit="scene", disable=None) as bar:
        rows = make_calibration(
            domain, path, scenes=count, seed=seed, renderer=renderer, report=bar.update
        )
    click.echo(f"{path}: {rows} blocks in {count} scenes")
