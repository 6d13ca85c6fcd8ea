"""Says what a speaker takes back or rules out: "the red block, no, the green one", "the red block
instead of the green one"; and near misses, of which nobody can tell what is meant."""

from __future__ import annotations

import numpy as np

from nsrm_harness.data.draws import Draws, Values
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.domain.rewriting import Repairs

#: Share of sentences with a further step, of descriptions without an article, of those without a
#: noun, and of commas before and behind what is said in between.
FOLLOWED, BARE, WITHOUT_NOUN, COMMA = 0.3, 0.15, 0.2, 0.6


class RepairSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.repairs is None:
            raise ValueError("the domain's wording has no repairs")
        super().__init__(domain, rng)
        self._repairs: Repairs = domain.repairs

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        action = self._choose(self._domain.actions)
        relation = self._choose(action.phrases).split()
        is_object = self._rng.random() < 0.5
        wrong, right = self._corrected()
        if self._rng.random() < 0.5:
            between = self._choose(self._repairs.corrections)
            first, second = wrong, right
        else:
            between = self._choose(self._repairs.exclusions)
            first, second = right, wrong
        article = [] if self._rng.random() < BARE else ["the"]
        # Which of two descriptions is taken back is only known if the relation is said again.
        again = [] if is_object else relation
        said = [
            *again, *article, *self._described(first), *self._between(between),
            *again, *article, *self._described(second),
        ]  # fmt: skip
        other = self._values()
        described = ["the", *self._described(other)]
        words = [*said, *relation, *described] if is_object else [*described, *said]
        pair = (right, other) if is_object else (other, right)
        program = [Step(action.name, *pair)]
        words = [*self._speaker.words("{before} {do}"), *words]
        if self._rng.random() < FOLLOWED:
            further = self._step()
            program.append(further)
            lead = self._choose([", then", "and then", ". then", ". after that ,"])
            words += [lead, *self._speaker.words("{order}", further)]
        return " ".join(" ".join(words).split()), tuple(program)

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        do, relation = self._speaker.words("{do}"), self._relation()
        more, less = self._unclear()
        one, other, further, fourth = (["the", *self._described(self._values())] for _ in range(4))
        correction = self._between(self._choose(self._repairs.corrections))
        exclusion = self._between(self._choose(self._repairs.exclusions))
        words = self._choose(
            [
                # Which one is taken back?
                [*do, *one, *relation, *other, *correction, *further],
                # Is it small?
                [*do, *more, *correction, *less, *relation, *other],
                # Where is it put?
                [*do, *one, "not", *relation, *other],
                [*do, *one, *exclusion, *other],
                [*do, *one, *correction, *other],
                [*do, *one, *correction],
                [*do, *one, *relation, *exclusion],
                [*do, *one, *relation, *other, *correction, "don't"],
                [*do, *one, *correction, *do, *other],
                [*do, *one, *exclusion, *other, *relation, *further, *self._relation(), *fourth],
                [*do, *one, *relation, *other, *exclusion, *further, *self._relation(), *fourth],
                [*do, "neither", *one, "nor", *other, *relation, *further],
                [*do, *one, "or", *other, *relation, *further],
                ["do not", *do, *one, *exclusion, *other, *relation, *further],
                [*do, "anything", *exclusion, *one, *relation, *other],
                [*do, "anything but", *one, *relation, *other],
                ["is", *one, *exclusion, *other, *relation, *further],
                ["throw", *one, *exclusion, *other, *relation, *further],
                [*do, *one, *exclusion, *other, "under", *further],
                [*correction, *one, *relation, *other],
            ]
        )
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())

    def _corrected(self) -> tuple[Values, Values]:
        """Values, and others that say as much and something else."""
        right = self._values()
        types = {self._domain.concept(name).attribute for name in right}
        while True:
            said = [each for each in sorted(types) if self._rng.random() < 0.7]
            wrong = tuple(self._choose(self._domain.attribute(each).values).name for each in said)
            if wrong and not {*wrong} <= {*right}:
                return wrong, right

    def _unclear(self) -> tuple[list[str], list[str]]:
        """A description, and one of which nobody can tell whether it has all its values."""
        types = self._rng.permutation(len(self._domain.attributes))[:2]
        several = [self._choose(self._domain.attributes[each].values).name for each in types]
        again = self._choose(self._domain.attributes[types[0]].values).name
        return ["the", *self._described(tuple(several))], ["the", *self._described((again,))]

    def _described(self, values: Values) -> list[str]:
        """Words for an object, without an article."""
        every = [self._choose(self._domain.concept(name).words) for name in values]
        noun = [] if self._rng.random() < WITHOUT_NOUN else self._speaker.words("{noun}")
        # One word, so that it is known where the description ends.
        return [*every, *noun[-1:]]

    def _between(self, text: str) -> list[str]:
        """What is said in between, with commas or without."""
        comma = [[","] if self._rng.random() < COMMA else [] for _ in range(2)]
        return [*comma[0], *text.split(), *comma[1]]

    def _relation(self) -> list[str]:
        return self._choose(self._choose(self._domain.actions).phrases).split()
