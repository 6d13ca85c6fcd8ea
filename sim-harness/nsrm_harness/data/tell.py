"""Tells demonstrations in everyday wording: many sentences for each episode of a file, and near
misses."""

from __future__ import annotations

from pathlib import Path

from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.data.near_misses import NearMisses
from nsrm_harness.data.seeds import generator
from nsrm_harness.data.told import Told
from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import Speaker
from nsrm_harness.domain.grammar import Grammar

#: Number of sentences of which one is plain.
PLAIN = 3


def tell(domain: Domain, episodes: Path, count: int, near_misses: int, seed: int) -> Told:
    """`count` sentences for each episode of a file, and so many near misses.

    One of `PLAIN` sentences, at least one, is in the grammar that a model is first trained on.

    `domain`: that of the episodes, with everyday wording.
    """
    told, grammar = Told([], [], []), Grammar(domain)
    plain = -(-count // PLAIN)
    with GroundTruth(episodes) as judge:
        for number in range(len(judge)):
            rng = generator(seed, "told", number)
            speaker = Speaker(domain, rng)
            program = judge.truth(number).program
            told.sentences.extend(grammar.sentence(rng, program).text for _ in range(plain))
            told.sentences.extend(" ".join(speaker.sentence(program)) for _ in range(count - plain))
            told.episodes.extend([number] * count)
    misses = NearMisses(domain, generator(seed, "near_misses", 0))
    told.near_misses.extend(misses.sentence() for _ in range(near_misses))
    return told
