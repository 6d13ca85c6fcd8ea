"""``harness trials``: measures how often the arm does what a sentence says."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import episodes_options, workers_of

QUICK = 5
"""Number of episodes per row with `--quick`."""
WORST, BEST = 20, 4
"""Numbers of worst and best episodes that are filmed."""


@click.command("trials")
@click.option(
    "--episodes", type=click.IntRange(1), default=500, show_default=True, help="Episodes per row."
)
@click.option(
    "--quick", is_flag=True, help="Five episodes per row, from scratch and without films."
)
@click.option(
    "--disturbed",
    is_flag=True,
    help="Rows that are disturbed on purpose, with closed and open loop.",
)
@click.option("--row", "names", multiple=True, help="Run only this row; may be repeated.")
@episodes_options(
    "out/trials", "Folder for the table and its data; an interrupted run in it is resumed."
)
def command(
    episodes: int,
    quick: bool,
    disturbed: bool,
    names: tuple[str, ...],
    seed: int,
    jobs: int,
    ray: str | None,
    quiet: bool,
    out: Path,
) -> None:
    """Let the arm execute random sentences, judged by the simulator's ground truth.

    The model plans through the core from the camera and the detector; the arm has only images and
    its joints. In the control row it is given the true poses and sub-goals.

    Exit code 1 if a goal was missed by more than chance explains.
    """
    from nsrm_harness.evaluation.manipulation_trials import trials_report as report
    from nsrm_harness.evaluation.manipulation_trials.disturbed_episode import DISTURBED_ROWS
    from nsrm_harness.evaluation.manipulation_trials.rows import ROWS
    from nsrm_harness.evaluation.manipulation_trials.run_trials import films, run

    known = {row.name: row for row in (*ROWS, *DISTURBED_ROWS)}
    if unknown := sorted(set(names) - set(known)):
        raise click.BadParameter(f"{unknown[0]!r}: expected one of {', '.join(known)}")
    rows = [known[name] for name in names] or [*(DISTURBED_ROWS if disturbed else ROWS)]
    count = QUICK if quick else episodes
    if quick:
        (out / "trials.jsonl").unlink(missing_ok=True)
    with workers_of(jobs, ray) as workers:
        ended = run(rows, count, seed, workers, out / "trials.jsonl", quiet=quiet)
        lines = report.counted(rows, ended)
        if not quick:
            films(report.worst(lines, WORST), rows, seed, workers, out / "worst")
            films(report.best(lines, BEST), rows, seed, workers, out / "best")
    report.write_csv(lines, out / "trials.csv")
    report.draw(lines, out / "trials.png")
    text = report.text(lines)
    (out / "trials.md").write_text(f"{text}\n", encoding="utf-8")
    click.echo(text)
    click.echo(f"tables and plot: {out / 'trials.csv'} {out / 'trials.md'} {out / 'trials.png'}")
    if missed := report.missed(lines):
        click.echo(f"harness: {'; '.join(missed)}", err=True)
        sys.exit(1)
