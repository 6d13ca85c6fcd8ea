"""``harness onnx``: writes a model file as ONNX graphs."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("onnx")
@click.option(
    "--model",
    "model_path",
    type=click.Path(path_type=Path),
    default=Path("weights-codegen/tabletop/tabletop.safetensors"),
    show_default=True,
    help="Model file.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("out/onnx"),
    show_default=True,
    help="Output folder.",
)
def command(model_path: Path, out: Path) -> None:
    """Write a graph for each job of `cargo compare`, of 12 tokens and 6 objects, after comparing it
    with the trainer's model in ONNX Runtime.
    """
    from nsrm_harness.learning.comparison.onnx_export import write_graphs

    for path in write_graphs(model_path, out):
        click.echo(f"{path}: written")
