"""``harness demo``: a sentence and a scene in; a program, sub-goals and pictures out."""

from __future__ import annotations

import json
import sys
from contextlib import closing
from pathlib import Path

import click

from nsrm_harness import domain as domains
from nsrm_harness.commands.options import seed_option
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
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of text.")
def command(sentence: str | None, seed: int, out: Path | None, as_json: bool) -> None:
    """Plan SENTENCE in the scene of a seed; without a sentence, one that fits.

    A sentence that can't be obeyed is refused with the reason and exit code 2; the
    scene is shown all the same.
    """
    folder = out or Path("out") / f"demo-{seed}"
    with closing(open_renderer()) as renderer:
        shown = show(domains.load(), renderer, seed, sentence, folder)
    pictures = [str(path) for path in shown.pictures]
    if as_json:
        click.echo(json.dumps(shown.document | {"pictures": pictures}, ensure_ascii=False))
    else:
        click.echo(shown.text)
    if shown.refusal is not None:
        click.echo(f"refused: {shown.refusal}", err=True)
    if not as_json:
        click.echo(f"pictures: {' '.join(pictures)}")
    if shown.refusal is not None:
        sys.exit(2)
