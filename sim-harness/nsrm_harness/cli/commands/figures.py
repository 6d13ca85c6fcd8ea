"""``harness figures``: reproduces the paper's figures 2 to 5 with the arm."""

from __future__ import annotations

import sys
from pathlib import Path

import click
from tqdm import tqdm

from nsrm_harness.cli.commands.options import episodes_options, make_folder, workers_of


@click.command("figures")
@click.option(
    "--variations",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Number of scenes per figure; the first one is drawn.",
)
@episodes_options("out/figures", "Folder for the pictures, figures.csv and figures.jsonl.")
def command(variations: int, seed: int, jobs: int, ray: str | None, quiet: bool, out: Path) -> None:
    """Let the arm execute the sentences of the paper's figures 2 to 5 in random scenes.

    The model plans from the camera and the detector; the simulator's ground truth judges each
    finished step. Exit code 1 if a figure does significantly worse than its goal, or there is an
    unexpected contact.
    """
    from nsrm_harness import domain as domains
    from nsrm_harness.paper.figures import figures_report as report
    from nsrm_harness.paper.figures.run_figures import run
    from nsrm_harness.paper.figures.scenes import FIGURES

    make_folder(out)
    domain = domains.load()
    pictures = {figure.number: out / f"figure_{figure.number}.png" for figure in FIGURES}
    tasks = [
        (
            (figure.number, variation),
            (figure, seed, variation, None if variation else pictures[figure.number], domain),
        )
        for figure in FIGURES
        for variation in range(variations)
    ]
    with (
        workers_of(jobs, ray) as workers,
        tqdm(total=len(tasks), unit=" episodes", disable=quiet) as bar,
    ):
        ended = {}
        for key, each in workers.each(run, tasks):
            ended[key] = each
            bar.update()
    every = [ended[key] for key in sorted(ended)]
    report.write_csv(every, out / "figures.csv")
    report.write_jsonl(every, out / "figures.jsonl")
    click.echo(report.text(every))
    click.echo(f"pictures: {' '.join(str(path) for path in pictures.values())}")
    if missed := report.missed(every):
        click.echo(f"harness: {'; '.join(missed)}", err=True)
        sys.exit(1)
