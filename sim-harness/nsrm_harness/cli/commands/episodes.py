"""``harness episodes``: makes an episode file, in several processes, resumable."""

from __future__ import annotations

import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from tqdm import tqdm

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import (
    Sizes,
    Span,
    Values,
    domain_option,
    jobs_option,
    negated,
    ray_option,
    seed_option,
    workers_of,
)
from nsrm_harness.common.workers import Workers
from nsrm_harness.data.demonstrator import describe
from nsrm_harness.data.generate import SPLITS, Settings, ShardProgress, generate
from nsrm_harness.simulation.render import KINDS


@click.command("episodes")
@click.option("--split", type=click.Choice(list(SPLITS)), required=True, help="Kind of data.")
@click.option("--count", type=click.IntRange(1), help="Number of episodes.")
@domain_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="data/DOMAIN/SPLIT.h5",
    help="File to write.",
)
@seed_option
@jobs_option
@ray_option
@click.option("--steps", type=Span(), help="Number of steps; each is equally frequent.")
@click.option("--objects", type=Span(), help="Number of blocks.")
@click.option("--attributes", type=Span(), help="Number of attribute values in a description.")
@click.option(
    "--exclude",
    type=Values(),
    multiple=True,
    help="No block has all of these attribute values; may be repeated.",
)
@click.option("--renderer", type=click.Choice(KINDS), default="auto", show_default=True)
@click.option(
    "--disturbance",
    type=Sizes(),
    help="Differences from training, such as camera_m=0.01,camera_deg=1,light=0.1,color=0.1,"
    "depth_m=0.001; the scenes are the same at all sizes.",
)
@click.option(
    "--stacks",
    type=click.FloatRange(0.0, 1.0),
    help="Share of episodes that begin with a block standing on another one, from 0 to 1; none by "
    "default. In half of them or more, the sentence names one of these two blocks.",
)
@click.option(
    "--fixed-light",
    "vary_light",
    is_flag=True,
    callback=negated,
    help="Use the same light in all episodes.",
)
@click.option(
    "--no-final-images",
    "final_image",
    is_flag=True,
    callback=negated,
    help="Omit the images of final scenes, which are only for people: a quarter faster.",
)
def command(
    split: str, domain_path: Path, out: Path | None, jobs: int, ray: str | None, **changes: Any
) -> None:
    """Generate a file of demonstrations: initial scene, sentence, final scene.

    Ctrl-C keeps the finished episodes; the same command resumes from them and gives the same
    file, byte for byte.
    """
    domain = domains.load(domain_path)
    # Options that are called like a setting, where they are given, come before the split's.
    given = {name: value for name, value in changes.items() if value is not None}
    settings = replace(SPLITS[split], **given)
    path = out or Path("data") / domain.name / f"{split}.h5"
    with workers_of(jobs, ray) as workers:
        _generate(settings, domain, path, workers)


def _generate(settings: Settings, domain: domains.Domain, path: Path, workers: Workers) -> None:
    begun = time.monotonic()
    last = ShardProgress(0, Counter())
    there: int | None = None
    with tqdm(total=settings.count, unit="episode", disable=None) as bar:

        def report(progress: ShardProgress) -> None:
            nonlocal last, there
            last = progress
            there = progress.done if there is None else there
            bar.set_postfix_str(f"rejected: {describe(progress.rejected)}")
            bar.update(progress.done - bar.n)

        try:
            made = generate(settings, domain, path, workers, report)
        except KeyboardInterrupt:
            click.echo(
                f"{path}: interrupted with {last.done} of {settings.count} episodes finished; "
                f"run the same command to resume",
                err=True,
            )
            sys.exit(130)
    if not made:
        click.echo(f"{path}: already exists, made with these settings")
        return
    seconds = time.monotonic() - begun
    made_now = settings.count - (there or 0)
    rate = made_now / seconds / workers.count
    click.echo(
        f"{path}: {settings.count} episodes, {path.stat().st_size / 1e6:.1f} MB; "
        f"{made_now} made in {seconds:.0f} s, {rate:.1f} per second and process; "
        f"rejected attempts: {describe(last.rejected)}"
    )
