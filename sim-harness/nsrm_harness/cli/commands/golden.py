"""``harness golden``: writes the golden vectors with which all forms of the model must agree."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("golden")
@click.option(
    "--model",
    "model_path",
    type=click.Path(path_type=Path),
    default=Path("weights-codegen/tabletop/tabletop.safetensors"),
    show_default=True,
    help="Model file.",
)
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("data/tabletop/validation.h5"),
    show_default=True,
    help="Episode file with scenes and sentences.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("tests/golden"),
    show_default=True,
    help="Output folder.",
)
def command(model_path: Path, data: Path, out: Path) -> None:
    """Compute every layer, every module and the whole pipeline with the trainer's code."""
    from nsrm_harness.learning.export import read_model
    from nsrm_harness.learning.golden import write_golden

    write_golden(read_model(model_path), data, out)
    click.echo(f"{out}: golden.safetensors, cases.json")
