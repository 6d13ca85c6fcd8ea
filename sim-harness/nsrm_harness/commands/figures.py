"""``harness figures``: the paper's figures 2 to 5, carried out by the arm."""

from __future__ import annotations

from pathlib import Path

import click
from tqdm import tqdm

from nsrm_harness.commands.options import jobs_option, ray_option, seed_option, workers_of
from nsrm_harness.errors import HarnessError


@click.command("figures")
@click.option(
    "--variations",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Scenes of each figure; the first is drawn.",
)
@seed_option
@jobs_option
@ray_option
@click.option("--quiet", is_flag=True, help="No progress.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("out/figures"),
    show_default=True,
    help="Folder for the pictures, figures.csv and figures.jsonl.",
)
def command(variations: int, seed: int, jobs: int, ray: str | None, quiet: bool, out: Path) -> None:
    """Have the arm carry the sentences of the paper's figures 2 to 5 out, in random scenes.

    The model plans from what camera and detector see; the truth of the simulator judges each step
    when it is done.
    """
    from nsrm_harness.figures import report
    from nsrm_harness.figures.scenes import FIGURES
    from nsrm_harness.figures.show import run

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarnessError(
            f"can't make the folder {out}: {error.strerror}: another --out"
        ) from None
    pictures = {figure.number: out / f"figure_{figure.number}.png" for figure in FIGURES}
    tasks = [
        (
            (figure.number, variation),
            (figure, seed, variation, None if variation else pictures[figure.number]),
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
