"""``harness detect``: measures how well objects are found without the simulator's mask."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import Span, domain_option, seed_option
from nsrm_harness.common.json_text import json_text


@click.command("detect")
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    default=Path("data/tabletop/test.h5"),
    show_default=True,
    help="Episode file; its initial scenes are used.",
)
@click.option(
    "--after",
    type=Span(),
    help="Instead of --data: scenes after programs with this many steps.",
)
@click.option(
    "--count",
    type=click.IntRange(1),
    default=100,
    show_default=True,
    help="Number of scenes for --after.",
)
@domain_option
@seed_option
@click.option(
    "--noise-mm",
    type=click.FloatRange(0.0),
    default=0.0,
    help="Standard deviation of the noise added to depth.",
)
@click.option(
    "--dropout",
    type=click.FloatRange(0.0, 1.0),
    default=0.0,
    help="Share of pixels whose depth is removed.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Picture to write, with the detections in the three worst scenes.",
)
def command(
    data: Path,
    after: tuple[int, int] | None,
    count: int,
    domain_path: Path,
    seed: int,
    noise_mm: float,
    dropout: float,
    as_json: bool,
    out: Path | None,
) -> None:
    """Detect the objects of every scene and compare them with the mask's boxes."""
    from nsrm_harness.evaluation.detector.measure import draw, measure
    from nsrm_harness.evaluation.detector.scenes import Picture, after_programs, of_file, with_noise

    pictures: Iterable[Picture] = of_file(data)
    if after is not None:
        pictures = after_programs(domains.load(domain_path), after, count, seed)
    if noise_mm or dropout:
        pictures = with_noise(pictures, noise_mm / 1000, dropout, seed)
    figures, worst = measure(pictures)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        draw(worst).save(out)
    click.echo(json_text(figures.as_json(), indent=2) if as_json else str(figures))
    if out is not None and not as_json:
        click.echo(out)
