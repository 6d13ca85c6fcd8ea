"""``harness comparison``: plots the times of `cargo compare`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("comparison")
@click.argument("measured", type=click.Path(path_type=Path), metavar="FILE.csv")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("out/compare.png"),
    show_default=True,
    help="Plot.",
)
def command(measured: Path, out: Path) -> None:
    """Plot the times that `cargo compare` has written to FILE.csv."""
    from nsrm_harness.learning.comparison.plot import draw, read

    times = read(measured)
    out.parent.mkdir(parents=True, exist_ok=True)
    draw(times, out)
    click.echo(f"plot: {out}")
