"""``harness publish``: copies a finished report into the project."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("publish")
@click.option(
    "--from",
    "folder",
    type=click.Path(path_type=Path),
    default=Path("runs/tables"),
    show_default=True,
    help="Output folder of 'harness tables'.",
)
@click.option(
    "--readme-only",
    is_flag=True,
    help="Only copy the figures of this checkout's own report into its README.",
)
def command(folder: Path, readme_only: bool) -> None:
    """Copy the report into this checkout, and its figures into the README."""
    from nsrm_harness.paper.tables.publish import publish, update_readme

    if readme_only:
        update_readme(Path.cwd())
        return
    publish(folder / "report", Path.cwd())
    click.echo("published")
