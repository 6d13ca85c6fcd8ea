"""Says steps in phrases that are read as others: "the red block is supposed to be on the blue one";
and near misses, in which such phrases, or what is like them, order nothing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nsrm_harness.data.draws import Draws
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: What is like such phrases and orders nothing.
OTHERWISE = (
    "{moved} was supposed to be {relation}", "{moved} is not supposed to be {relation}",
    "is {moved} supposed to be {relation}", "{moved} is never to be {relation}",
    "{moved} is supposed to be", "is supposed to be {relation}", "{moved} is supposed to",
    "why is {moved} supposed to be {relation}", "i suppose {moved} is {relation}",
    "{moved} is {relation} so that it is good", "so that it is {relation}",
    "{do} {moved} so that it is not {relation}", "{do} {moved} so that it is",
    "do not {do} {moved} so that it is {relation}", "{do} {moved} so that nothing is {relation}",
    "i would appreciate it if you did not {do} {moved} {relation}", "if you could",
    "i would appreciate it", "it would be nice if {moved} was {relation}",
    "if you could {do} {moved} {relation}, would you", "when you're done {do} {moved}",
    "i was wondering if {moved} is {relation}", "you were supposed to {do} {moved} {relation}",
    "when you're done", "if you could have {done} {moved} {relation}", "if {moved} is {relation}",
)  # fmt: skip


class RephrasedSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if not domain.rephrasing:
            raise ValueError("the domain's wording reads no phrases as others")
        super().__init__(domain, rng)
        self._said: dict[str, list[str]] = {}
        for text, read_as in domain.rephrasing.items():
            if text != read_as:
                self._said.setdefault(read_as, []).append(text)

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        while True:
            program: Program = (self._step(),)
            if self._rng.random() < FOLLOWED:
                program = (*program, self._step())
            sentence = f" {' '.join(self._speaker.sentence(program))} "
            if every := [each for each in self._said if f" {each} " in sentence]:
                read_as = self._choose(every)
                text = self._choose(self._said[read_as])
                return sentence.replace(f" {read_as} ", f" {text} ", 1).strip(), program

    def near_miss(self) -> str:
        """A sentence that must be refused."""
        step = self._step()
        words = self._choose(OTHERWISE).replace("{done}", "moved").replace(",", " ,")
        return " ".join(self._speaker.words(words, step))

    def phrases(self) -> Iterator[str]:
        """All that is read as something else."""
        return (text for texts in self._said.values() for text in texts)
