"""``harness convert``: converts model files of earlier schemas."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("convert")
@click.argument("paths", type=click.Path(path_type=Path), metavar="FILE...", nargs=-1)
def command(paths: tuple[Path, ...]) -> None:
    """Convert models of schemas 2 to 5 and baselines of 'baseline 1' to the current one.

    Each FILE is replaced by one that understands the same: the hash then covers the metadata, and
    a model gets the parameters that it does not have yet.
    """
    from nsrm_harness.learning.convert import convert

    if not paths:
        raise click.UsageError("no file given: name at least one file to convert")
    for path in paths:
        convert(path)
        click.echo(f"{path}: converted")
