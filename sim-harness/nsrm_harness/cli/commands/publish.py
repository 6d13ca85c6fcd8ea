"""``harness publish``: a finished report and its model into the project."""

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
    help="Folder in which 'harness tables' worked.",
)
def command(folder: Path) -> None:
    """Copy report and first model into this checkout, and its figures into the README.

    Afterwards the static arrays and the golden vectors are to be made again.
    """
    from nsrm_harness.paper.tables.publish import publish
    from nsrm_harness.paper.tables.run_tables import PUBLISHED

    publish(folder / "report", folder / PUBLISHED, Path.cwd())
    click.echo(
        "published; now: cargo run --release -p nsrm-codegen -- "
        "weights-codegen/tabletop/tabletop.safetensors "
        "--out weights-codegen/tabletop/src/generated.rs && "
        f"cargo harness golden --data {folder / 'data' / 'validation.h5'}"
    )
