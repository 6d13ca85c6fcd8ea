"""``harness wording``: teaches a trained model everyday wording."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import seed_option


@click.command("wording")
@click.option(
    "--model",
    "model_path",
    type=click.Path(path_type=Path),
    required=True,
    help="Model file of 'harness train': its perception and actions stay as they are.",
)
@click.option(
    "--episodes",
    type=click.Path(path_type=Path),
    required=True,
    help="Demonstrations; what is said about them is in the file of the same name with the ending "
    ".jsonl, made by 'harness sentences'.",
)
@click.option(
    "--validation",
    type=click.Path(path_type=Path),
    required=True,
    help="The same of other demonstrations, on which the certainty is fitted.",
)
@click.option(
    "--wording",
    type=click.Path(path_type=Path),
    show_default="that of the paper's domain",
    help="TOML file with the wording of the sentences.",
)
@click.option(
    "--test",
    type=click.Path(path_type=Path),
    required=True,
    help="Episode file on which the model is evaluated; its metrics go into the model file.",
)
@click.option("--epochs", type=click.IntRange(1), help="Passes over the near misses.")
@click.option(
    "--share",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=1.0,
    show_default=True,
    help="Share of the way from the weights before the lesson to those behind it.",
)
@click.option(
    "--lessons",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Number of lessons, each with the next seed and its own folder; the model is their mean.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    help="Folder for the model, the training curve and the checkpoint.",
)
@seed_option
@click.option("--resume", is_flag=True, help="Resume from the checkpoint in the folder.")
def command(
    model_path: Path,
    episodes: Path,
    validation: Path,
    wording: Path | None,
    test: Path,
    epochs: int | None,
    share: float,
    lessons: int,
    out: Path,
    seed: int,
    resume: bool,
) -> None:
    """Teach a trained model what people say about demonstrations, and to refuse near misses.

    After Ctrl-C, the same command with --resume gives the same model as an uninterrupted run.
    """
    from nsrm_harness.domain.everyday import EVERYDAY
    from nsrm_harness.evaluation.language import measure_episodes
    from nsrm_harness.evaluation.metrics import evaluate, load_model
    from nsrm_harness.learning.export import read_model, write_metrics, write_model
    from nsrm_harness.learning.model import Model
    from nsrm_harness.learning.wording import Lesson, WordingConfig, between, fitted, teach

    base, config = read_model(model_path), WordingConfig()
    if epochs is not None:
        config = config.with_epochs(epochs)
    wording = wording or EVERYDAY
    try:
        lesson = Lesson.read(base, episodes, episodes.with_suffix(".jsonl"), wording)
        taught: list[tuple[Model, Model]] = []
        for number in range(seed, seed + lessons):
            folder = out if lessons == 1 else out / f"seed-{number}"
            model = teach(lesson, config, number, folder, resume, say=click.echo)
            taught.append((lesson.untaught(number), model))
        model = between(taught, share)
    except KeyboardInterrupt:
        click.echo(f"{out}: interrupted; run the same command with --resume to continue", err=True)
        sys.exit(130)
    heard = Lesson.read(base, validation, validation.with_suffix(".jsonl"), wording)
    path = out / "model.safetensors"
    record = {"seed": seed, "lessons": lessons, "share": share}
    write_model(path, fitted(lesson, model, heard, config, record))
    metrics = evaluate(load_model(path), test)
    write_metrics(path, metrics.as_json())
    click.echo(metrics)
    for row in measure_episodes(load_model(path), test, seed):
        click.echo(row)
    click.echo(f"model: {path}")
