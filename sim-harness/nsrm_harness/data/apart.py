"""Says the values of an object apart: "the small block that is red", "the small and red block"."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import Speaker, everyday_of
from nsrm_harness.domain.program import Program
from nsrm_harness.domain.recogniser import means_list

_T = TypeVar("_T")


class ApartSentences:
    """Draws sentences about programs of one domain."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.apart is None:
            raise ValueError("the domain's wording has nothing between values")
        self._domain = domain
        self._apart = domain.apart
        self._lexicon = domain.lexicon()
        self._nouns = {*everyday_of(domain).rules["noun"]}
        self._speaker = Speaker(domain, rng)
        self._rng = rng

    def draw(self, program: Program) -> str | None:
        """A sentence about the program, in which values stand apart; None if none can."""
        words = self._speaker.sentence(program)
        told = self._taken_apart(words)
        return " ".join(told) if told != words else None

    def near_miss(self, program: Program) -> str | None:
        """The same with another value of the same type in place of one that stands apart."""
        while True:
            words = self._speaker.sentence(program)
            told = self._taken_apart(words, is_wrong=True)
            if told == words:
                return None
            # "Put red and blue on green" lists two.
            if not means_list(self._domain, sentence := " ".join(told)):
                return sentence

    def _taken_apart(self, words: list[str], is_wrong: bool = False) -> list[str]:
        told: list[str] = []
        at = 0
        while at < len(words):
            first, second, behind, next_word = (words[at : at + 4] + ["", "", ""])[:4]
            if first not in self._lexicon or second not in self._lexicon:
                told.append(first)
                at += 1
                continue
            if is_wrong:
                second = self._other_value(first)
            # Values of the next description would be read as of this one.
            is_free = behind in self._nouns and next_word not in self._lexicon
            if is_free and self._rng.random() < 0.7:
                told += [first, behind, *self._choose(self._apart.phrases).split(), second]
                at += 3
            else:
                told += [first, *self._choose(self._apart.between).split(), second]
                at += 2
        return told

    def _other_value(self, word: str) -> str:
        """A word for another value of the type that a word names a value of."""
        named = self._domain.concepts[self._lexicon[word]]
        values = self._domain.attribute(named.attribute).values
        return self._choose([value.words[0] for value in values if value.name != named.name])

    def _choose(self, every: Sequence[_T]) -> _T:
        return every[int(self._rng.integers(len(every)))]
