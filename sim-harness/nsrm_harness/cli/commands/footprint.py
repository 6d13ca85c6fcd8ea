"""``harness footprint``: plots what the image of a micro-controller is made of."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("footprint")
@click.argument("counted", type=click.Path(path_type=Path), metavar="FILE.csv")
@click.option(
    "--model",
    "model_path",
    type=click.Path(path_type=Path),
    show_default="the built-in model",
    help="Model file of the image.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("out/footprint.png"),
    show_default=True,
    help="Plot.",
)
def command(counted: Path, model_path: Path | None, out: Path) -> None:
    """Plot the flash by parts of the model, and the memory by processor, that `cargo footprint` has
    written to FILE.csv."""
    from nsrm_harness.evaluation.quantised import load
    from nsrm_harness.visualization.footprint import draw, read

    rows, models = read(counted), load(model_path)
    out.parent.mkdir(parents=True, exist_ok=True)
    draw(rows, {each: model.info()["flash"] for each, model in models.items()}, out)
    click.echo(f"plot: {out}")
