"""``harness convert``: model files of the schema before this one, for this one."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("convert")
@click.argument("paths", type=click.Path(path_type=Path), metavar="FILE...", nargs=-1)
def command(paths: tuple[Path, ...]) -> None:
    """Give models and baselines of schema 2 and 'baseline 1' a hash that covers their metadata.

    Each FILE is replaced. Weights and metadata stay as they are.
    """
    from nsrm_harness.learning.convert import convert

    if not paths:
        raise click.UsageError("expected the files to convert, found none: name at least one")
    for path in paths:
        convert(path)
        click.echo(f"{path}: converted")
