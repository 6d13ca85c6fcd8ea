"""``harness convert``: converts model files of the previous schema."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("convert")
@click.argument("paths", type=click.Path(path_type=Path), metavar="FILE...", nargs=-1)
def command(paths: tuple[Path, ...]) -> None:
    """Convert models of schema 2 and baselines of 'baseline 1': their hash then covers the
    metadata.

    Each FILE is replaced. Weights and metadata do not change.
    """
    from nsrm_harness.learning.convert import convert

    if not paths:
        raise click.UsageError("no file given: name at least one file to convert")
    for path in paths:
        convert(path)
        click.echo(f"{path}: converted")
