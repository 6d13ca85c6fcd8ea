"""Finds where the first of two steps of a sentence ends, which no final scene shows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from itertools import dropwhile, pairwise

import numpy as np

from nsrm_harness.learning.dataset import Sentences
from nsrm_harness.learning.model import GROUP_TOKEN

ROUNDS = 3
"""Rounds of `first_ends`."""
RARE = 1e-2
"""Count of a pair of words that was not found."""
LEAST_BEGUN = 0.002
"""Smallest share of second steps that begin with a word."""


def first_ends(sentences: Sentences, double: np.ndarray) -> np.ndarray:
    """The number of tokens of the first step of each sentence; of one step, all of them. `[N]`

    * `double`: indices of the sentences with two steps, each of two descriptions

    It is the longest end that some sentence has and behind which a word stands with which steps
    begin: "…, on its right" is an end, and ", on the right" of ", on the right of the blue block
    put …" is none, since no step begins with "of". With which words steps begin follows from the
    most likely divisions of what stands between two: into an end, and words in pairs that are
    frequent in the divisions found before.
    """
    found = sentences.length.copy()
    found[double] = sentences.usual_ends()[double] + 1
    numbers: list[int] = double.tolist()
    rows = [
        tuple(row[:length].tolist())
        for row, length in zip(sentences.tokens, sentences.length, strict=True)
    ]
    places = [[at for at, token in enumerate(row) if token == GROUP_TOKEN] for row in rows]
    tails = [row[at[-1] + 1 :] for row, at in zip(rows, places, strict=True) if at]
    # Nouns, and words that may stand behind a description alone: any of them, or none.
    alone = {tail[0] for tail in tails if len(tail) == 1}

    def bare(tail: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(dropwhile(alone.__contains__, tail))

    ends = Counter(map(bare, tails))
    for _ in range(ROUNDS):
        pairs: Counter[tuple[int, int]] = Counter()
        for n in numbers:
            pairs.update(pairwise((GROUP_TOKEN, *rows[n][found[n] : places[n][2] + 1])))
        firsts: Counter[int] = Counter()
        for (first, _), count in pairs.items():
            firsts[first] += count

        for n in numbers:
            first, behind = places[n][1] + 1, places[n][2]
            likelihood = {
                at: math.log(ends[bare(rows[n][first:at])])
                + _log_likelihood((GROUP_TOKEN, *rows[n][at : behind + 1]), pairs, firsts)
                for at in range(first, behind + 1)
                if bare(rows[n][first:at]) in ends
            }
            found[n] = max(likelihood, key=likelihood.__getitem__, default=first)
    # The longest end before a word that steps begin with.
    begins = Counter(rows[n][found[n]] for n in numbers)
    for n in numbers:
        first, behind = places[n][1] + 1, places[n][2]
        good = [
            at
            for at in range(first, behind + 1)
            if bare(rows[n][first:at]) in ends and begins[rows[n][at]] > LEAST_BEGUN * len(numbers)
        ]
        found[n] = max(good, default=int(found[n]))
    return found


def _log_likelihood(
    words: tuple[int, ...], pairs: Mapping[tuple[int, int], int], firsts: Mapping[int, int]
) -> float:
    """Log likelihood of words, but for a constant, by how often each follows the one before."""
    return sum(math.log((pairs[pair] + RARE) / (firsts[pair[0]] + 1.0)) for pair in pairwise(words))
