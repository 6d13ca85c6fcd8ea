"""``harness refusals``: measures how many of the sentences that must be refused are refused."""

from __future__ import annotations

from pathlib import Path

import click

from nsrm_harness.cli.commands.options import model_option
from nsrm_harness.common.json_text import json_text


@click.command("refusals")
@model_option
@click.option(
    "--set",
    "which",
    type=click.Choice(["validation", "test"]),
    default="test",
    show_default=True,
    help="Set of sentences; the episode file is that of the split with this name.",
)
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    show_default="data/tabletop/SET.h5",
    help="Episode file with scenes and good sentences.",
)
@click.option(
    "--count",
    type=click.IntRange(1),
    show_default="160",
    help="Number of sentences of each kind.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("out/refusals"),
    show_default=True,
    help="Folder for refusals.csv and refusals.png.",
)
def command(
    model_path: Path | None,
    which: str,
    data: Path | None,
    count: int | None,
    as_json: bool,
    out: Path,
) -> None:
    """Plan sentences that must be refused, and the good ones of a file, with the core."""
    from nsrm_harness.evaluation.metrics import load_model
    from nsrm_harness.evaluation.refusals.measure import measure
    from nsrm_harness.evaluation.refusals.plot import draw_report
    from nsrm_harness.evaluation.refusals.sentences import COUNT

    path = data or Path("data/tabletop") / f"{which}.h5"
    report = measure(load_model(model_path), path, which, count or COUNT, quiet=as_json)
    out.mkdir(parents=True, exist_ok=True)
    report.write_csv(out / "refusals.csv")
    draw_report(report, out / "refusals.png")
    click.echo(json_text(report.as_json(), indent=2) if as_json else str(report))
