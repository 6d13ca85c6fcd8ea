"""Says towers and rows, "build a tower of the red, the green and the blue block", as the domain's
wording has them; and near misses, which mean none."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nsrm_harness.data.draws import ListDraws, Values
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import ALL, BOTH, ITSELF, Program, Step
from nsrm_harness.domain.recogniser import means_list
from nsrm_harness.domain.rewriting import ArrangedStep, Arrangements, Pattern

#: Share of sentences with a further step behind the list.
FOLLOWED = 0.3
#: Share of sentences about all objects that fit, and not a list: "stack the red blocks".
SEVERAL = 0.2


class ArrangedSentences(ListDraws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.arrangements is None:
            raise ValueError("the domain's wording has no towers and rows")
        super().__init__(domain, rng)
        self._said: Arrangements = domain.arrangements

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        opening, closing, steps = self._around()
        if self._rng.random() < SEVERAL:
            several, step = self._several(steps)
            words, program = [*self._before(), opening, several, closing], (step,)
        else:
            objects = self._objects()
            words = [*self._before(), opening, *self._list(objects), closing]
            program = program_of(steps, objects)
        if self._rng.random() < FOLLOWED:
            further = self._step()
            lead = self._choose([", then", "and then", ". then", ". after that ,", "and"])
            words += [lead, *self._speaker.words("{order}", further)]
            program = (*program, further)
        return " ".join(" ".join(words).split()), program

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        while means_list(self._domain, sentence := self._near_miss()):
            pass
        return sentence

    def _near_miss(self) -> str:
        first, *others = self._objects()
        opening, closing, steps = self._around()
        one, listed = self._described(first), self._list((first, *others))
        relation = self._speaker.words("{relation}", self._step())
        several = ["all", *first, "blocks"], self._described(others[0])
        # The first of a tower from the top is moved, and may be several.
        below, above = several[::-1] if steps.reversed else several
        words = self._choose(
            [
                # One object alone, and others in its place.
                [opening, *one, closing],
                [opening, *one, "or", *self._described(others[0]), closing],
                [opening, *one, "and not", *self._described(others[0]), closing],
                # Where the tower or the row is to be.
                [opening, *listed, closing, *relation],
                [opening, *listed, *relation, closing],
                # Several on which another one would be put.
                [opening, *below, "and", *above, closing],
                # Words of another pattern behind the list, or that say two things.
                [opening, *listed, self._closing_of_others(opening)],
                [opening, *listed, "from left to right", "from top to bottom"],
                ["do not", opening, *listed, closing],
                ["unless you", opening, *listed, closing],
            ]
        )
        return " ".join(" ".join([*self._before(), *words]).split())

    def _around(self) -> tuple[str, str, ArrangedStep]:
        """What stands before and behind a list, and what is meant."""
        pattern = self._choose(self._said.patterns)
        closing = self._choose(list(pattern.closings))
        steps = self._said.steps[pattern.closings[closing]]
        return self._choose(pattern.openings), closing, steps

    def _several(self, steps: ArrangedStep) -> tuple[str, Step]:
        """Words for several objects at once, and what is done with them."""
        values, which = self._values(), self._choose((ALL, ALL, BOTH))
        noun = self._choose(self._nouns[2:])
        texts = ["all {}", "all the {}", "all of the {}", "the {}"]
        if which == BOTH:
            texts = ["both {}", "both of the {}", "the two {}"]
        words = self._choose(texts).format(" ".join((*values, noun)))
        return words, Step(steps.action, values, (), object_which=which, reference_which=ITSELF)

    def _closing_of_others(self, opening: str) -> str:
        """What cannot stand behind a list with this before it."""
        own = {closing for each in self._with(opening) for closing in each.closings} - {""}
        every = {closing for each in self._said.patterns for closing in each.closings} - {""}
        return self._choose(sorted(each for each in every if not each.endswith((*own,))))

    def _with(self, opening: str) -> list[Pattern]:
        return [each for each in self._said.patterns if opening in each.openings]

    def _step(self) -> Step:
        action = self._choose([action.name for action in self._domain.actions])
        moved, reference = self._objects()[:2]
        return Step(action, moved, reference)


def program_of(steps: ArrangedStep, objects: tuple[Values, ...]) -> Program:
    """The program of a tower or a row of these objects, as they are listed."""
    placed = objects[::-1] if steps.reversed else objects
    return tuple(Step(steps.action, moved, before) for before, moved in pairwise(placed))
