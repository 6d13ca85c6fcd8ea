"""``harness latency``: measures how fast a robot's processes answer."""

from __future__ import annotations

from pathlib import Path

import click

from nsrm_harness.evaluation.process_trials.latency import draw, read, table
from nsrm_harness.evaluation.process_trials.run_program import (
    out_option,
    programs_options,
    run_trial,
)


@click.command("latency")
@programs_options
@click.option(
    "--samples",
    type=click.IntRange(100),
    default=20000,
    show_default=True,
    help="Number of samples of each.",
)
@out_option("out/latency")
@click.option(
    "--measured", type=click.Path(path_type=Path), help="Plot this file instead of measuring."
)
def command(
    nsrm_trials: Path | None, nsrm: Path | None, samples: int, out: Path, measured: Path | None
) -> None:
    """Measure the times from a sentence to its first sub-goal and from a frame to its scene,
    through processes and shared memory; write OUT/latency.md and OUT/latency.png.

    This needs two cores. Run nothing else meanwhile: the figures depend on the machine.
    """
    if measured is None:
        options = ["--samples", str(samples)]
        measured = run_trial("latency", nsrm_trials, nsrm, out, options).with_name("latency.jsonl")
    rows = read(measured)
    out.mkdir(parents=True, exist_ok=True)
    draw(rows, out / "latency.png")
    text = table(rows)
    (out / "latency.md").write_text(text + "\n", encoding="utf-8")
    click.echo(text)
    click.echo(f"plot: {out / 'latency.png'}")
