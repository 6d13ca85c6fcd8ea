"""Says what is left out of a description: "all blocks except the red one", "the block that is not
red"; and near misses, which leave nothing out that is meant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nsrm_harness.data.draws import Draws, Values
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.relations import kinds_of
from nsrm_harness.data.several import (
    MOST_MOVED,
    Several,
    drawn,
    fitting,
    several_steps,
    values_of,
)
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import ALL, Excepted, Program, Step
from nsrm_harness.domain.rewriting import Exceptions

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: Share of those about a single object, which says what it is not.
SINGLE = 0.3
#: Share of exceptions behind the place.
BEHIND = 0.25
NOUNS = ("block", "cube", "one", "piece", "brick", "object")


class ExceptionSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.exceptions is None or domain.several is None:
            raise ValueError("the domain's wording leaves nothing out")
        super().__init__(domain, rng)
        self._said: Exceptions = domain.exceptions
        self._everything = domain.several.alone

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        step = self._single() if self._rng.random() < SINGLE else self._several()
        words, program = self.of_step(step), [step]
        if self._rng.random() < FOLLOWED:
            further = self._step()
            program.append(further)
            lead = self._choose((", then", "and then", ". then", ". after that ,"))
            words = f"{words} {lead} {' '.join(self._speaker.words('{order}', further))}"
        return " ".join(words.split()), tuple(program)

    def of_step(self, step: Step) -> str:
        """A sentence of a step that leaves something out."""
        lists = self._domain.lists
        while True:
            said = self._order(step)
            if step.object_which is None or lists is None or not lists.is_tower_aside(said.split()):
                return said

    def _order(self, step: Step) -> str:
        place = [self._choose(self._domain.action(step.action).phrases)]
        before = [*self._speaker.words("{before}"), *self._speaker.words("{do}")]
        if step.reference_except is not None:
            moved = self._speaker.words("{moved}", step)
            negated = self._negated(step.reference, step.reference_except)
            return _joined(*before, *moved, *place, *negated)
        place += self._speaker.words("{reference}", step)
        left_out = step.object_except
        if left_out is None:
            raise ValueError("the step leaves nothing out")
        if step.object_which is None:
            return _joined(*before, *self._negated(step.object, left_out), *place)
        moved = self._all(step.object)
        if left_out.which == ALL and self._rng.random() < 0.4:
            is_not = [self._choose(self._said.negations), *self._words_of(left_out.values)]
            if moved[-1] not in self._everything:
                return _joined(*before, *moved, *is_not, *place)
        excepted = self._excepted(left_out)
        if self._rng.random() < BEHIND:
            comma = "," if self._rng.random() < 0.5 else ""
            return _joined(*before, *moved, *place, comma, *excepted)
        comma = "," if self._rng.random() < 0.3 else ""
        return _joined(*before, *moved, comma, *excepted, comma, *place)

    def _several(self) -> Step:
        which = ALL if self._rng.random() < 0.5 else None
        values, reference = self._values(), self._values()
        kept = values if self._rng.random() < 0.5 else ()
        own = {self._domain.concept(name).attribute for name in kept}
        left_out = tuple(
            name for name in self._values() if self._domain.concept(name).attribute not in own
        )
        if not left_out:
            return self._several()
        action = self._choose(self._domain.actions).name
        return Step(
            action, kept, reference, object_which=ALL, object_except=Excepted(left_out, which)
        )

    def _single(self) -> Step:
        step = self._step()
        own, other = step.object[:1], self._values()[:1]
        if self._rng.random() < 0.3:
            own = ()
        types = [{self._domain.concept(name).attribute for name in each} for each in (own, other)]
        if types[0] & types[1]:
            return self._single()
        left_out = Excepted(other, ALL)
        if self._rng.random() < 0.7:
            return replace(step, object=own, object_except=left_out)
        return replace(step, reference=own, reference_except=left_out)

    def near_miss(self) -> str:
        """A sentence with such words that must be refused."""
        step = self._step()
        moved, reference = (self._speaker.words(name, step) for name in ("{moved}", "{reference}"))
        do, other = self._speaker.words("{do}"), ["the", *self._described(self._values())]
        every, place = (
            self._all(self._values()),
            self._choose(self._domain.action(step.action).phrases),
        )
        on = self._choose(self._domain.actions[0].phrases)
        phrase, negation = (
            self._choose(each) for each in (self._said.phrases, self._said.negations)
        )
        one, another = self._rng.permutation(len(self._domain.attributes))[:2]
        some, values = (
            self._words_of((self._choose(self._domain.attributes[int(at)].values).name,))
            for at in (one, another)
        )
        words = self._choose(
            [
                [*do, *moved, "except", *other, place, *reference],
                [*do, *every, phrase, place, *reference],
                [*do, *every, place, *reference, phrase],
                [*do, *every, place, *reference, phrase, *other, on, *moved],
                [*do, *every, phrase, *other, "or", *moved, place, *reference],
                [*do, *every, phrase, "the leftmost one", place, *reference],
                [*do, *every, phrase, "that", place, *reference],
                [*do, *every, phrase, "both of them", place, *reference],
                [*do, "no block", phrase, *other, place, *reference],
                [*do, "anything", phrase, *other, place, *reference],
                [*do, "nothing", phrase, *other, place, *reference],
                ["do not", *do, *every, phrase, *other, place, *reference],
                ["is everything", phrase, *other, place, *reference],
                ["everything", phrase, *other, "is", place, *reference],
                [*do, *moved, place, *every, phrase, *other],
                [phrase, *other, *do, *moved, place, *reference],
                [*do, *moved, negation, place, *reference],
                [*do, "the block", negation, on, *other, place, *reference],
                [*do, "the block", negation, "the", *values, "one", place, *reference],
                [*do, *moved, place, "where", *other, negation, *values],
                [negation, *values, *do, *moved, place, *reference],
                [*do, "all", *some, "blocks", "not", *values, place, *reference],
                [*do, "the", *some, "block", "not", *values, place, *reference],
                [*do, "all", *some, "blocks", "not", *some, place, *reference],
                [*do, *every, "all", phrase, *other, place, *reference],
                [*do, *every, phrase, "two", *self._described(()), place, *reference],
                [*do, *every, phrase, *other, "if", *moved, "is", place, *reference],
            ]
        )
        return _joined(*self._speaker.words("{before}"), *words)

    def _all(self, values: Values) -> list[str]:
        if not values and self._rng.random() < 0.5:
            return [self._choose(self._everything)]
        noun = self._choose(NOUNS) + "s"
        return [
            "all",
            *(["the"] if self._rng.random() < 0.5 else []),
            *self._words_of(values),
            noun,
        ]

    def _excepted(self, left_out: Excepted) -> list[str]:
        phrase = self._choose(self._said.phrases)
        values, noun = self._words_of(left_out.values), self._choose(NOUNS)
        if left_out.which is None:
            end = [noun] if self._rng.random() < 0.8 else []
            return [phrase, "the", *values, *end]
        if self._rng.random() < 0.3:
            return [phrase, *values]
        article = ["the"] if self._rng.random() < 0.7 else []
        return [phrase, *article, *values, f"{noun}s"]

    def _negated(self, values: Values, left_out: Excepted) -> list[str]:
        negation = self._choose(
            [text for text in self._said.negations if " are" not in text and "aren" not in text]
        )
        described = self._described(values)
        return ["the", *described, negation, *self._words_of(left_out.values)]

    def _described(self, values: Values) -> list[str]:
        return [*self._words_of(values), self._choose(NOUNS)]

    def _words_of(self, values: Values) -> list[str]:
        return [self._choose(self._domain.concept(name).words) for name in values]


def _joined(*words: str) -> str:
    return " ".join(" ".join(words).split())


def excepted_programs(
    domain: Domain, truth: Truth, rng: np.random.Generator, count: int
) -> tuple[list[Several], list[Several]]:
    """So many random programs about an episode's initial scene that move all blocks of a kind
    except one, and as many whose exception fits none of them or several."""
    values = values_of(domain, truth)
    kinds = sorted({kind for own in values for kind in kinds_of(own)})
    true: list[Several] = []
    untrue: list[Several] = []
    for step, reference, moved in several_steps(domain, values):
        for left_out in kinds if step.object_which == ALL else ():
            if {*left_out} & {*step.object}:
                continue
            # The reference is not moved, and may be the one that is left out.
            without = [at for at in moved if not {*left_out} <= {*values[at]}]
            among = [at for at in fitting(values, step.object) if {*left_out} <= {*values[at]}]
            program = (replace(step, object_except=Excepted(left_out)),)
            if len(among) != 1:
                untrue.append(Several(program, (), reference + 1))
            elif 1 <= len(without) <= MOST_MOVED:
                ids = tuple(block + 1 for block in without)
                true.append(Several(program, ids, reference + 1))
    return drawn(domain, true, rng, count), drawn(domain, untrue, rng, count)
