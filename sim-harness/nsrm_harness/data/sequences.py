"""Says two steps in another order than that in which they are carried out: "before you put the red
block on the blue one, put …"; and near misses, whose steps have no such order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nsrm_harness.data.draws import Draws
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.domain.rewriting import SequenceWords

#: Share of sentences that ask politely, of those with a comma where there may be one.
ASKED, COMMA = 0.2, 0.7
#: What says something else of two steps than their order.
OTHERWISE = (
    "if you", "unless you", "until you", "while you", "without", "instead of", "in case you",
    "whenever you", "before somebody", "after i", "because you", "not before you",
)  # fmt: skip


class SequenceSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.sequence is None:
            raise ValueError("the domain's wording says no order of steps")
        super().__init__(domain, rng)
        self._words: SequenceWords = domain.sequence

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        first, second = self._step(), self._step()
        comma = [","] if self._rng.random() < COMMA else []
        kind = int(self._rng.integers(5))
        if kind == 0:
            words = [*self._introduced(self._words.later, second), *comma, *self._order(first)]
        elif kind == 1:
            words = [*self._order(first), *self._introduced(self._words.later, second)]
        elif kind == 2:
            then = ["then"] if self._rng.random() < 0.3 else []
            introduced = self._introduced(self._words.earlier, first)
            words = [*introduced, *comma, *then, *self._order(second)]
        elif kind == 3:
            words = [*self._order(second), *self._introduced(self._words.earlier, first)]
        else:
            mark = self._choose([",", ".", ""])
            thought = self._choose(self._words.afterthoughts)
            words = [*self._order(second), mark, thought, *self._plain(first)]
        return self._sentence(words), (first, second)

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        later = self._introduced(self._words.later, self._step())
        earlier = self._introduced(self._words.earlier, self._step())
        order, other, further = (self._order(self._step()) for _ in range(3))
        described = self._speaker.words("{moved}", self._step())
        state = self._speaker.words("{moved} is {relation}", self._step())
        thought = self._choose(self._words.afterthoughts).split()
        step = self._step()
        words = self._choose(
            [
                later,
                earlier,
                [*order, *later[:2]],
                [*order, ", then", *other, *earlier],
                [*order, *earlier, "and then", *further],
                [*later, ",", *order, ". then", *further],
                [*thought, *order, ",", *other],
                [*order, *self._choose(OTHERWISE).split(), *other],
                [*self._choose(OTHERWISE).split(), *order, ",", *other],
                ["once", *state, ",", *order],
                [*order, "when", *state],
                ["did you", *order, *later],
                ["do not", *order, *later],
                [*order, "before", *described],
                [*order, "after", *described],
                # What "it" is has not been said yet.
                [*later, ",", *self._speaker.words("{do} it {relation}", step)],
                [*later, "or", *earlier, ",", *order],
                [*order, *later, *earlier],
            ]
        )
        return self._sentence(words)

    def _introduced(self, texts: Mapping[str, str], step: Step) -> list[str]:
        """A step behind the words that say when it is carried out."""
        text = self._choose(list(texts))
        if texts[text]:
            return [*text.split(), *self._speaker.words("{moved} {where}", step)]
        return [*text.split(), *self._plain(step)]

    def _order(self, step: Step) -> list[str]:
        if self._rng.random() < ASKED:
            return self._speaker.words("{asking} {do} {moved} {where}", step)
        return self._plain(step)

    def _plain(self, step: Step) -> list[str]:
        return self._speaker.words("{do} {moved} {where}", step)

    def _sentence(self, words: Sequence[str]) -> str:
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())
