"""``harness chaos``: kills a robot's processes at random and judges their journal."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.evaluation.process_trials.chaos import judge
from nsrm_harness.evaluation.process_trials.journal import read
from nsrm_harness.evaluation.process_trials.run_program import (
    out_option,
    programs_options,
    run_trial,
)


@click.command("chaos")
@programs_options
@click.option(
    "--kills", type=click.IntRange(1), default=1000, show_default=True, help="Number of kills."
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Random seed.")
@out_option("out/chaos")
@click.option(
    "--journal",
    type=click.Path(path_type=Path),
    help="Judge this journal instead of running processes.",
)
def command(
    nsrm_trials: Path | None,
    nsrm: Path | None,
    kills: int,
    seed: int,
    out: Path,
    journal: Path | None,
) -> None:
    """Kill processes of a robot with SIGKILL at random moments, suspend and restart them, and send
    sentences all the while; then check in the journal whether anything was lost or done twice.

    Exit code 1 if so.
    """
    if journal is None:
        options = ["--kills", str(kills), "--seed", str(seed)]
        journal = run_trial("chaos", nsrm_trials, nsrm, out, options)
    verdict = judge(read(journal))
    click.echo(verdict.text())
    sys.exit(1 if verdict.faults else 0)
