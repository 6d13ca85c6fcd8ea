"""``harness growth``: plots how the work of a plan grows."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("growth")
@click.argument("counted", type=click.Path(path_type=Path), metavar="FILE.csv")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("out/growth.png"),
    show_default=True,
    help="Plot.",
)
def command(counted: Path, out: Path) -> None:
    """Plot the instructions that `cargo run --release -p nsrm-bench --bin growth` has written to
    FILE.csv."""
    from nsrm_harness.visualization.growth import draw, read

    counts = read(counted)
    out.parent.mkdir(parents=True, exist_ok=True)
    draw(counts, out)
    click.echo(f"plot: {out}")
