"""Sentences told about the episodes of a file, and near misses, after which nothing is done.

A file has JSON lines. The first names the episodes: split, seed and count of their file. Each other
line is ``{"sentence": …, "episode": …, "later": …}``, which also says whether it is told as if
steps came before it: "and then put …". The episode is null for a near miss, which says whether it
is untimely: its commands are in an impossible order. `tell` makes them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import EpisodeFileError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.whole_file import write_whole
from nsrm_harness.data.file import open_checked

KIND = "nsrm sentences"
SCHEMA = 3


@dataclass(frozen=True)
class Told:
    """The content of a file of sentences."""

    #: Commands.
    sentences: list[str]
    #: The episode that shows each of them.
    episodes: list[int]
    #: Whether each of them is told as a later step.
    later: list[bool]
    #: Sentences after which nothing was done,
    near_misses: list[str]
    #: and those with commands in an impossible order.
    untimely: list[str]


def write_told(path: Path, episodes: Path, told: Told) -> None:
    """Writes the sentences about the episodes of a file."""
    lines: list[dict[str, Any]] = [
        {"kind": KIND, "schema": SCHEMA, "episodes": _identity(episodes)},
        *(
            {"sentence": sentence, "episode": episode, "later": later}
            for sentence, episode, later in zip(
                told.sentences, told.episodes, told.later, strict=True
            )
        ),
        *(
            {"sentence": sentence, "episode": None, "untimely": untimely}
            for sentences, untimely in ((told.near_misses, False), (told.untimely, True))
            for sentence in sentences
        ),
    ]
    text = "".join(json_text(line, ensure_ascii=False) + "\n" for line in lines)
    write_whole(path, text.encode())


def read_told(path: Path, episodes: Path) -> Told:
    """Reads the sentences about the episodes of a file. Raises ``EpisodeFileError``."""
    told, identity = Told([], [], [], [], []), _identity(episodes)
    lines = _lines(path)
    first = next(lines, (1, {}))[1]
    if not (first.get("kind") == KIND and first.get("schema") == SCHEMA):
        raise EpisodeFileError(
            f"{path}: not a file of sentences: create it with 'harness sentences'"
        )
    if first.get("episodes") != identity:
        raise EpisodeFileError(f"{path}: its sentences are not about the episodes in {episodes}")
    for number, line in lines:
        sentence, episode = line.get("sentence"), line.get("episode")
        if not isinstance(sentence, str):
            raise EpisodeFileError(f"{path}: line {number} has no sentence")
        if episode is None:
            kind = told.untimely if line.get("untimely") else told.near_misses
            kind.append(sentence)
        elif isinstance(episode, int) and 0 <= episode < identity["count"]:
            told.sentences.append(sentence)
            told.episodes.append(episode)
            told.later.append(bool(line.get("later")))
        else:
            raise EpisodeFileError(
                f"{path}: line {number}: expected an episode below {identity['count']} or null, "
                f"got {episode!r}"
            )
    return told


def _lines(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    try:
        with path.open(encoding="utf-8") as file:
            for number, text in enumerate(file, start=1):
                line = json.loads(text)
                if not isinstance(line, dict):
                    raise EpisodeFileError(f"{path}: line {number} is not a JSON object")
                yield number, line
    except (OSError, ValueError) as error:
        raise EpisodeFileError(f"{path}: cannot read the sentences: {error}") from error


def _identity(episodes: Path) -> dict[str, Any]:
    with open_checked(episodes) as file:
        settings = json.loads(str(file.attrs["settings"]))
    return {name: settings[name] for name in ("split", "seed", "count")}
