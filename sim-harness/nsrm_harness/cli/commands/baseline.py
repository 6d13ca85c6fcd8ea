"""``harness baseline``: trains and measures the paper's baseline."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import seed_option


@click.command("baseline")
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("data/tabletop"),
    show_default=True,
    help="Folder with train.h5, test.h5 and calibration.h5.",
)
@seed_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="runs/baseline-DATA-SEED",
    help="Folder for baseline.safetensors.",
)
def command(data: Path, seed: int, out: Path | None) -> None:
    """Train the paper's baseline, a network without programs, and print its metrics.

    It is told where the steps of a command end, in training and on test.
    """
    from nsrm_harness.learning.baseline.run_baseline import run
    from nsrm_harness.learning.baseline.train import BaselineConfig
    from nsrm_harness.learning.run_training import Files

    folder = out or Path("runs") / f"baseline-{data.name}-{seed}"
    try:
        run(Files.of(data), BaselineConfig(), seed, folder, say=click.echo)
    except KeyboardInterrupt:
        click.echo("interrupted; nothing was written", err=True)
        sys.exit(130)
