"""``harness quantised``: measures what a model loses with rounded weights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import (
    lists_option,
    model_option,
    relations_option,
    seed_option,
)


@click.command("quantised")
@model_option
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    multiple=True,
    required=True,
    help="Episode file, judged by the paper's metrics; may be repeated.",
)
@relations_option
@lists_option
@click.option(
    "--near-misses",
    type=click.IntRange(1),
    default=4000,
    show_default=True,
    help="Number of near misses of everyday wording.",
)
@click.option("--out", type=click.Path(path_type=Path), help="CSV file to write.")
@click.option("--page", type=click.Path(path_type=Path), help="Page with a table to replace.")
@seed_option
def command(
    model_path: Path | None,
    data: Sequence[Path],
    relations: Sequence[Path],
    lists: Sequence[Path],
    near_misses: int,
    out: Path | None,
    page: Path | None,
    seed: int,
) -> None:
    """Judge a model with its weights as trained and rounded, on the same episodes and sentences."""
    from nsrm_harness import domain as domains
    from nsrm_harness.evaluation import quantised
    from nsrm_harness.evaluation.metrics import domain_of

    if page is not None:
        # Before the work of minutes.
        quantised.with_table(page.read_text(encoding="utf-8"), [])
    models = quantised.load(model_path)
    domain = domain_of(models["f32"], domains.load())
    rows: list[quantised.QuantisedRow] = []
    for row in quantised.measure_all(models, domain, data, relations, lists, near_misses, seed):
        click.echo(str(row))
        rows.append(row)
    if page is not None:
        replaced = quantised.with_table(page.read_text(encoding="utf-8"), rows)
        page.write_text(replaced, encoding="utf-8")
    if out is not None:
        quantised.write_rows(out, rows)
        click.echo(f"{out}: {len(rows)} rows")
