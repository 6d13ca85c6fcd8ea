"""``harness train``: trains a model on demonstrations and writes its model file."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import seed_option


@click.command("train")
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("data/tabletop"),
    show_default=True,
    help="Folder with train.h5, validation.h5, test.h5 and calibration.h5.",
)
@click.option(
    "--config",
    type=click.Path(path_type=Path),
    help="TOML file that overrides the defaults of learning/config.py.",
)
@click.option("--quick", is_flag=True, help="A reduced training, with learning/quick.toml.")
@seed_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="runs/DATA-SEED",
    help="Folder for the model, the training curves and the checkpoint.",
)
@click.option("--resume", is_flag=True, help="Resume from the checkpoint in the folder.")
def command(
    data: Path, config: Path | None, quick: bool, seed: int, out: Path | None, resume: bool
) -> None:
    """Train a model on initial scenes, sentences and final scenes; write its model file.

    After Ctrl-C, the same command with --resume gives the same model as an uninterrupted run.
    """
    from nsrm_harness.learning.config import QUICK_CONFIG, ConfigError, read_config
    from nsrm_harness.learning.run_training import Files, finish, fit

    if quick and config is not None:
        raise ConfigError("--quick and --config cannot be combined: --quick selects a config file")
    settings = read_config(QUICK_CONFIG if quick else config)
    folder = out or Path("runs") / f"{data.name}-{seed}"
    files = Files.of(data)
    try:
        fitted = fit(files, settings, seed, folder, resume, say=click.echo)
        finish(fitted, files.test, folder, say=click.echo)
    except KeyboardInterrupt:
        click.echo(
            f"{folder}: interrupted; run the same command with --resume to continue", err=True
        )
        sys.exit(130)
