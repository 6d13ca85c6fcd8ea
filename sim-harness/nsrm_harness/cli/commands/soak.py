"""``harness soak``: runs a robot's processes for hours and measures their resources."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.evaluation.process_trials.journal import read
from nsrm_harness.evaluation.process_trials.run_program import (
    out_option,
    programs_options,
    run_trial,
)
from nsrm_harness.evaluation.process_trials.soak import draw, read_soak


@click.command("soak")
@programs_options
@click.option("--hours", type=float, default=1.0, show_default=True, help="Duration.")
@click.option(
    "--every",
    type=click.IntRange(1),
    default=10,
    show_default=True,
    help="Seconds between samples.",
)
@out_option("out/soak")
@click.option(
    "--journal",
    type=click.Path(path_type=Path),
    help="Read this journal instead of running processes.",
)
def command(
    nsrm_trials: Path | None,
    nsrm: Path | None,
    hours: float,
    every: int,
    out: Path,
    journal: Path | None,
) -> None:
    """Let a robot execute sentences for hours; write memory, open files and times as OUT/soak.md
    and OUT/soak.png.

    Exit code 1 if anything has grown, or sentences have become slow.
    """
    if journal is None:
        options = ["--hours", str(hours), "--every", str(every)]
        journal = run_trial("soak", nsrm_trials, nsrm, out, options)
    soak = read_soak(read(journal))
    out.mkdir(parents=True, exist_ok=True)
    draw(soak, out / "soak.png")
    text = "\n".join([soak.text(), *(f"FAULT: {fault}" for fault in soak.faults())])
    (out / "soak.md").write_text(text + "\n", encoding="utf-8")
    click.echo(text)
    click.echo(f"plot: {out / 'soak.png'}")
    sys.exit(1 if soak.faults() else 0)
