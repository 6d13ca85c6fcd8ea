"""``harness speed``: measures how fast trials of the arm run, and where their time goes."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import click
from tqdm import tqdm

from nsrm_harness.cli.commands.options import make_folder, out_option, quiet_option, seed_option


@click.command("speed")
@click.option(
    "--episodes",
    type=click.IntRange(1),
    default=20,
    show_default=True,
    help="Number of episodes for each kind of workers, from all rows in turn.",
)
@seed_option
@click.option(
    "--jobs",
    type=click.IntRange(1),
    multiple=True,
    default=(2,),
    show_default=True,
    help="Number of processes, in addition to one; may be repeated.",
)
@click.option(
    "--ray/--no-ray",
    "with_ray",
    default=None,
    show_default="where Ray is installed",
    help="Also measure a Ray cluster of two workers on this machine.",
)
@quiet_option
@out_option("out/speed", "Folder for the tables and the plot.")
def command(
    episodes: int, seed: int, jobs: tuple[int, ...], with_ray: bool | None, quiet: bool, out: Path
) -> None:
    """Measure episodes of `harness trials`: how many per minute by how many workers, where the time
    of one process goes, and how long a collision check takes.

    Run nothing else meanwhile: the figures depend on the machine.
    """
    from nsrm_harness.evaluation.manipulation_trials.speed import speed_report as report
    from nsrm_harness.evaluation.manipulation_trials.speed.measure_speed import rounds, run

    make_folder(out)
    is_on_ray = find_spec("ray") is not None if with_ray is None else with_ray
    count = episodes * rounds(jobs, with_ray=is_on_ray)
    with tqdm(total=count, unit=" episodes", disable=quiet) as bar:
        speed = run(episodes, seed, jobs, with_ray=is_on_ray, done=bar.update)
    written = report.write(speed, out)
    click.echo(report.text(speed))
    if with_ray is None and not is_on_ray:
        click.echo("\n- Ray is not installed and was not measured; --ray says how to install it.")
    click.echo(f"tables and plot: {' '.join(str(path) for path in written)}")
