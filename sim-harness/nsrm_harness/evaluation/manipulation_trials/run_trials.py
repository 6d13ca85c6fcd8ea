"""Runs all episodes of a table in parallel; each is saved as it ends and is not run again."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from tqdm import tqdm

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.workers import Workers
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.manipulation_trials import provenance, trial
from nsrm_harness.evaluation.manipulation_trials.disturbed_episode import (
    DisturbedRow,
    run_disturbed,
)
from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementVerdict
from nsrm_harness.evaluation.manipulation_trials.rows import TrialRow

FILMED = ("film.gif", "strip.png")
"""The files that `films` writes into a folder,"""
FILMS = re.compile(r"(succeeded|refused|failed)-\w+-\d+")
"""and the names of such folders."""


class TrialsError(HarnessError):
    """A file that does not belong to these trials."""


def run(
    rows: Sequence[TrialRow], episodes: int, seed: int, workers: Workers, path: Path, *, quiet: bool
) -> list[EpisodeResult]:
    """The first `episodes` episodes of each row.

    * `path`: file with one line per episode, after a header with the seed and the provenance (code
      and model)

    Raises `TrialsError` if the file has another seed, code or model.
    """
    kept = {(each.row, each.index): each for each in _kept(path, seed)}
    domain = domains.load()
    missing = [
        ((row.name, index), (row, seed, index, None, domain))
        for index in range(episodes)
        for row in rows
        if (row.name, index) not in kept
    ]
    with (
        path.open("a", encoding="utf-8") as file,
        tqdm(total=len(missing), unit=" episodes", disable=quiet or not missing) as bar,
    ):
        for key, ended in workers.each(episode, missing):
            kept[key] = ended
            file.write(json_text(asdict(ended)) + "\n")
            file.flush()
            bar.update()
    return [kept[row.name, index] for row in rows for index in range(episodes)]


def episode(
    row: TrialRow, seed: int, index: int, films: Path | None, domain: Domain
) -> EpisodeResult:
    """Runs an episode of any row: see `trial.run`."""
    if isinstance(row, DisturbedRow):
        return run_disturbed(row.kind, row.loop, seed, index, films, domain)
    return trial.run(row, seed, index, films, domain)


def films(
    shown: Sequence[EpisodeResult],
    rows: Sequence[TrialRow],
    seed: int,
    workers: Workers,
    folder: Path,
) -> None:
    """Runs these episodes again and films each into a folder of its own, after removing earlier
    films."""
    _remove_films(folder)
    by_name, domain = {row.name: row for row in rows}, domains.load()
    tasks = (
        (
            each,
            (by_name[each.row], seed, each.index, folder / _folder_of(each), domain),
        )
        for each in shown
    )
    for _ in workers.each(episode, tasks):
        pass


def _folder_of(ended: EpisodeResult) -> str:
    return f"{ended.end}-{ended.row}-{ended.index}"


def _remove_films(folder: Path) -> None:
    """Removes what `films` wrote, and nothing else."""
    for each in folder.glob("*"):
        if not (each.is_dir() and FILMS.fullmatch(each.name)):
            continue
        for name in FILMED:
            (each / name).unlink(missing_ok=True)
        if not any(each.iterdir()):
            each.rmdir()


def _kept(path: Path, seed: int) -> Iterator[EpisodeResult]:
    """The results that an interrupted run has left; its last line may be incomplete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    first, _, rest = text.partition("\n")
    made = provenance.digest()
    if not rest and not text.endswith("\n"):
        head = json_text({"seed": seed, "provenance": made})
        path.write_text(f"{head}\n", encoding="utf-8")
        return
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        path.write_text(whole, encoding="utf-8")
        rest = whole.partition("\n")[2]
    try:
        head = json.loads(first)
        if head["seed"] != seed:
            raise TrialsError(f"{path}: trials of seed {head['seed']}: use another --out")
        if head.get("provenance") != made:
            raise TrialsError(
                f"{path}: trials of another version of the code or the model: use another --out, "
                "or remove it"
            )
        for line in rest.splitlines():
            fields = json.loads(line)
            steps = (PlacementVerdict(**step) for step in fields["steps"])
            fields["steps"] = tuple(replace(step, touched=tuple(step.touched)) for step in steps)
            for several in ("corrected_m", "tries"):
                fields[several] = tuple(fields[several])
            yield EpisodeResult(**fields)
    except (ValueError, KeyError, TypeError) as error:
        raise TrialsError(
            f"{path}: {error}: not a file of trials; remove it, or use another --out"
        ) from error
