"""``harness sentences``: tells demonstrations in everyday wording."""

from __future__ import annotations

from pathlib import Path

import click

from nsrm_harness.cli.commands.options import seed_option


@click.command("sentences")
@click.option(
    "--episodes",
    type=click.Path(path_type=Path),
    required=True,
    help="Episode file with the demonstrations.",
)
@click.option(
    "--wording",
    type=click.Path(path_type=Path),
    show_default="that of the paper's domain",
    help="TOML file with everyday wording.",
)
@click.option(
    "--count",
    type=click.IntRange(1),
    default=16,
    show_default=True,
    help="Number of sentences for each demonstration.",
)
@click.option(
    "--near-misses",
    type=click.IntRange(0),
    default=300_000,
    show_default=True,
    help="Number of sentences after which nothing is done.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="EPISODES with the ending .jsonl",
    help="File to write.",
)
@seed_option
def command(
    episodes: Path, wording: Path | None, count: int, near_misses: int, out: Path | None, seed: int
) -> None:
    """Tell demonstrations in everyday wording: many sentences for each, and near misses, sentences
    of the same words after which nothing is done."""
    from nsrm_harness.data.file import Demonstrations
    from nsrm_harness.data.tell import tell
    from nsrm_harness.data.told import write_told
    from nsrm_harness.domain.everyday import EVERYDAY, with_everyday

    with Demonstrations(episodes) as demonstrations:
        domain = with_everyday(demonstrations.domain, wording or EVERYDAY)
    path = out or episodes.with_suffix(".jsonl")
    told = tell(domain, episodes, count, near_misses, seed)
    write_told(path, episodes, told)
    misses = len(told.near_misses) + len(told.untimely)
    click.echo(
        f"{path}: {len(told.sentences)} sentences about {len(set(told.episodes))} demonstrations, "
        f"{misses} near misses, {len(domain.vocabulary()) - 1} words"
    )
