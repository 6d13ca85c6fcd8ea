"""Generates sentences that must be refused in a scene, by kind of fault.

Each is a good sentence about the scene with one thing spoilt (`spoiler`). The hash of a sentence
decides to which set it belongs, whatever the scene; the sets have separate random streams and
episode files.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.domain.tokens import split
from nsrm_harness.evaluation.refusals.spoiler import (
    KINDS,
    OF_ORDER_WORDS,
    OF_PLAIN_DESCRIPTIONS,
    Situation,
    Spoiler,
)

#: Sets of sentences; each takes its scenes from the episode file of the same name.
SETS = ("validation", "test")
#: Default number of sentences of each kind.
COUNT = 160
#: Number of draws per requested sentence before giving up.
MAX_DRAWS = 100


class RefusalSetError(HarnessError):
    """A file whose scenes do not allow a kind of sentence."""


@dataclass(frozen=True)
class Item:
    """A sentence that must be refused."""

    scene: int
    sentence: str
    kind: str
    #: The word that was misspelt.
    meant: str | None = None


def make_items(
    domain: Domain, situations: Sequence[Situation], which: str, count: int = COUNT, seed: int = 0
) -> list[Item]:
    """`count` different sentences of each kind of the domain; deterministic.

    Raises `RefusalSetError` if the scenes do not allow as many.
    """
    return [
        item
        for number, kind in enumerate(KINDS)
        if must_refuse(domain, kind)
        for item in _items_of(
            kind, domain, situations, which, count, generator(seed, f"refusals_{which}", number)
        )
    ]


def _items_of(
    kind: str,
    domain: Domain,
    situations: Sequence[Situation],
    which: str,
    count: int,
    rng: np.random.Generator,
) -> list[Item]:
    """`count` different sentences of one kind."""
    spoiler = Spoiler(domain, rng)
    items: dict[str, Item] = {}
    for _ in range(MAX_DRAWS * count):
        if len(items) == count:
            break
        situation = situations[int(rng.integers(len(situations)))]
        spoilt = KINDS[kind](spoiler, situation)
        if spoilt is None or set_of(spoilt.sentence) != which:
            continue
        item = Item(situation.scene, spoilt.sentence, kind, spoilt.meant)
        items.setdefault(_key(spoilt.sentence), item)
    if len(items) < count:
        raise RefusalSetError(
            f"{kind}: {len(items)} of {count} sentences found in {len(situations)} scenes: "
            "use a file with more episodes, or a smaller --count"
        )
    return list(items.values())


def set_of(sentence: str) -> str:
    """The only set to which a sentence may belong, whatever its spelling and punctuation."""
    return SETS[hashlib.sha256(_key(sentence).encode()).digest()[0] % len(SETS)]


def _key(sentence: str) -> str:
    return " ".join(split(sentence))


def must_refuse(domain: Domain, kind: str) -> bool:
    """Whether a domain has this kind of sentences that must be refused."""
    if kind in OF_ORDER_WORDS:
        return bool(domain.grammar.order_words)
    has_relations = domain.everyday is not None and bool(domain.everyday.states())
    return not (has_relations and kind in OF_PLAIN_DESCRIPTIONS)
