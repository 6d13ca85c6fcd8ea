"""``harness demo``: plans a sentence in a scene, executes it, and draws the result."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import click

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import arm_option, seed_option
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.demo.run_demo import show
from nsrm_harness.simulation.render import open_renderer
from nsrm_harness.visualization.demo_listener import DemoListener, Stopped


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
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE.rrd",
    help="Also write a recording for the Rerun viewer.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of text.")
def command(
    sentence: str | None,
    seed: int,
    out: Path | None,
    with_arm: bool,
    record: Path | None,
    as_json: bool,
) -> None:
    """Plan and execute SENTENCE in the scene of a seed; by default a sentence that fits.

    A sentence that cannot be carried out is refused with the reason and exit code 2; the scene
    is shown all the same. The same holds for a sub-goal that the arm cannot reach, or on which
    the block would not stand.
    """
    folder = out or Path("out") / f"demo-{seed}"
    with _recording(record) as onlooker, closing(open_renderer()) as renderer:
        shown = show(
            domains.load(),
            renderer,
            seed,
            sentence,
            folder,
            with_arm=with_arm,
            onlooker=onlooker,
        )
    pictures = [str(path) for path in shown.pictures]
    if as_json:
        files = {"pictures": pictures} | ({} if record is None else {"recording": str(record)})
        click.echo(json_text(shown.document | files, ensure_ascii=False))
    else:
        click.echo(shown.text)
    if isinstance(shown.refusal, Stopped):
        click.echo(shown.refusal, err=True)
    elif shown.refusal is not None:
        click.echo(f"refused: {shown.refusal}", err=True)
        if shown.refusal.question is not None:
            click.echo(f"question: {shown.refusal.question}", err=True)
    if not as_json:
        if record is not None:
            click.echo(f"recording: {record}")
        click.echo(f"pictures: {' '.join(pictures)}")
    if shown.refusal is not None:
        sys.exit(2)


@contextmanager
def _recording(path: Path | None) -> Iterator[DemoListener]:
    """The listener that writes the recording; without a path, one that does nothing."""
    if path is None:
        yield DemoListener()
        return
    try:
        from nsrm_harness.visualization.recording.episode import Recording
        from nsrm_harness.visualization.recording.file import recorded
    except ModuleNotFoundError as error:
        raise HarnessError(
            f"--record needs the Python package rerun-sdk ({error}): `cargo demo --record` "
            "installs it; or: pip install --require-hashes -r sim-harness/requirements/record.txt"
        ) from error
    with recorded(path) as stream:
        yield Recording(stream)
