"""``harness demo``: a sentence and a scene in; a program, sub-goals and pictures out."""

from __future__ import annotations

import json
import sys
from contextlib import closing
from pathlib import Path

import click

from nsrm_harness import domain as domains
from nsrm_harness.commands.options import arm_option, seed_option
from nsrm_harness.demo.outcome import Stopped
from nsrm_harness.demo.show import show
from nsrm_harness.world.render import open_renderer


@click.command("demo")
@click.argument("sentence", required=False)
@seed_option
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    show_default="out/demo-SEED",
    help="Folder for the pictures and the scene.",
)
@arm_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of text.")
def command(
    sentence: str | None, seed: int, out: Path | None, with_arm: bool, as_json: bool
) -> None:
    """Plan SENTENCE in the scene of a seed; without a sentence, one that fits.

    A sentence that can't be obeyed is refused with the reason and exit code 2; the
    scene is shown all the same. So is a sub-goal that the arm can't reach or that would
    not stand.
    """
    folder = out or Path("out") / f"demo-{seed}"
    with closing(open_renderer()) as renderer:
        shown = show(domains.load(), renderer, seed, sentence, folder, with_arm=with_arm)
    pictures = [str(path) for path in shown.pictures]
    if as_json:
        click.echo(json.dumps(shown.document | {"pictures": pictures}, ensure_ascii=False))
    else:
        click.echo(shown.text)
    if isinstance(shown.refusal, Stopped):
        click.echo(shown.refusal, err=True)
    elif shown.refusal is not None:
        click.echo(f"refused: {shown.refusal}", err=True)
    if not as_json:
        click.echo(f"pictures: {' '.join(pictures)}")
    if shown.refusal is not None:
        sys.exit(2)
