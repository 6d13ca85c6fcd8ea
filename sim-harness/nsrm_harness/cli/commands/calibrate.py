"""``harness calibrate``: finds the least confidence at which few accepted commands are wrong."""

from __future__ import annotations

from pathlib import Path

import click

from nsrm_harness.cli.commands.options import model_option
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.whole_file import write_whole


@click.command("calibrate")
@model_option
@click.option(
    "--validation",
    type=click.Path(path_type=Path),
    default=Path("data/tabletop/validation.h5"),
    show_default=True,
    help="Episode file on whose sentences it is found.",
)
@click.option(
    "--also",
    "others",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Episode file of another split on which it is then counted, such as test or paraphrase; "
    "can be repeated.",
)
@click.option(
    "--count",
    type=click.IntRange(1),
    default=160,
    show_default=True,
    help="Number of sentences of each kind that must be refused.",
)
@click.option(
    "--risk",
    type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
    default=0.001,
    show_default=True,
    help="Greatest accepted share of wrong commands among those that are carried out.",
)
@click.option(
    "--level",
    type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
    default=0.95,
    show_default=True,
    help="Probability with which the limit is kept.",
)
@click.option(
    "--write",
    type=click.Path(path_type=Path),
    help="Write the model with the confidence that was found to this file; needs --model.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("out/calibration"),
    show_default=True,
    help="Folder for calibration.csv and calibration.png.",
)
def command(
    model_path: Path | None,
    validation: Path,
    others: tuple[Path, ...],
    count: int,
    risk: float,
    level: float,
    write: Path | None,
    as_json: bool,
    out: Path,
) -> None:
    """Find the least confidence of a plan at which few of the accepted commands are wrong.

    The guarantee holds for scenes and sentences like those of --validation. For your own, use
    `nsrm calibrate`.
    """
    import nsrm

    from nsrm_harness.evaluation.refusals.calibration import (
        RiskLimit,
        calibrate,
        draw_calibration,
        load_uncalibrated,
    )

    if write is not None and model_path is None:
        raise click.UsageError("--write needs --model: the built-in model has no file")
    limit = RiskLimit(risk, level)
    model = load_uncalibrated(model_path)
    report = calibrate(model, validation, others, limit, count, quiet=as_json)
    out.mkdir(parents=True, exist_ok=True)
    report.write_csv(out / "calibration.csv")
    draw_calibration(report, out / "calibration.png")
    if write is not None and model_path is not None:
        write_whole(write, nsrm.with_confidence(model_path.read_bytes(), report.found.threshold))
    click.echo(json_text(report.as_json(), indent=2) if as_json else str(report))
