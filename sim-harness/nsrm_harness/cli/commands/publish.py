"""``harness publish``: copies a finished report and its model into the project."""

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
def command(folder: Path) -> None:
    """Copy the report and the first model into this checkout, and its figures into the README.

    Afterwards, regenerate the static arrays and the golden vectors.
    """
    from nsrm_harness.paper.tables.publish import publish
    from nsrm_harness.paper.tables.run_tables import PUBLISHED

    publish(folder / "report", folder / PUBLISHED, Path.cwd())
    click.echo(
        "published; now run: cargo run --release -p nsrm-codegen -- "
        "weights-codegen/tabletop/tabletop.safetensors "
        "--out weights-codegen/tabletop/src/generated.rs && "
        f"cargo harness golden --data {folder / 'data' / 'validation.h5'}"
    )
