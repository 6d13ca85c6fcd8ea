"""``harness language``: measures which sentences models understand and refuse."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import (
    lists_option,
    relations_option,
    seed_option,
)


@click.command("language")
@click.option(
    "--model",
    "models",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Model file; may be repeated. By default the built-in model.",
)
@click.option(
    "--data",
    "data",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Episode file with sentences and programs; may be repeated.",
)
@relations_option
@lists_option
@click.option(
    "--near-misses",
    type=click.IntRange(0),
    default=20_000,
    show_default=True,
    help="Number of near misses of everyday wording.",
)
@click.option("--out", type=click.Path(path_type=Path), help="CSV file to write.")
@seed_option
def command(
    models: Sequence[Path],
    data: Sequence[Path],
    relations: Sequence[Path],
    lists: Sequence[Path],
    near_misses: int,
    out: Path | None,
    seed: int,
) -> None:
    """Count the sentences that models understand, refuse and take for something else, by set."""
    from nsrm_harness import domain as domains
    from nsrm_harness.evaluation import language
    from nsrm_harness.evaluation.metrics import domain_of, load_model
    from nsrm_harness.evaluation.relations import measure_relations

    rows: list[tuple[int, language.Counted]] = []
    for path in models or (None,):
        model = load_model(path)
        info = model.info()["training"]
        trained = int(info.get("wording", info)["seed"])
        own: list[language.Counted] = []
        for file in data:
            own += language.measure_episodes(model, file, seed)
        for file in relations:
            own += measure_relations(model, file, seed)
        domain = domain_of(model, domains.load())
        if near_misses > 0 and domain.everyday is not None:
            own.append(language.measure_near_misses(model, domain, near_misses, seed))
        for file in lists:
            own += language.measure_list(model, file, domain, seed)
        for row in own:
            click.echo(f"seed {trained}: {row}")
        rows += [(trained, row) for row in own]
    if out is not None:
        language.write_rows(out, rows)
        click.echo(f"{out}: {len(rows)} rows")
