"""Says which block is meant by counting: "the second red block from the left"; and near misses,
which count nothing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nsrm_harness.data.draws import Draws
from nsrm_harness.data.extremes import FARTHER_M, SAME_M, ExtremeDescriptions
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.relations import Described, step_of
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step

#: Share of sentences with a further step, and of further descriptions that are counted.
FOLLOWED, AGAIN = 0.3, 0.2
#: From where nobody can count.
NOWHERE = ("from the middle", "from the door", "from me", "from there", "from the blue one")
#: What is no number of one block.
NO_COUNTS = (
    "next",
    "last",
    "sixth",
    "other",
    "tenth",
    "second and third",
    "first two",
    "second or",
)


class OrdinalSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.ordinals is None:
            raise ValueError("the domain's wording counts nothing")
        super().__init__(domain, rng)
        self._ordinals = domain.ordinals
        self._ranked = list(domain.ranked())

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        program = [self._step(counted=True)]
        if self._rng.random() < FOLLOWED:
            program.append(self._step(counted=False))
        return " ".join(self._speaker.sentence(tuple(program))), tuple(program)

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        do, on = self._speaker.words("{do}"), self._choose(["on", "behind", "to the left of"])
        one, other, further = self._apart()
        noun = self._speaker.words("{noun}")
        count = self._choose(self._choose(self._ordinals.counts))
        start = self._choose(list(self._ordinals.starts))
        words = self._choose(
            [
                [*do, "the", count, one, *noun, on, "the", other, "one"],
                [*do, "the", one, "one", on, "the", count, other, *noun],
                [*do, "the", one, *noun, start, on, "the", other, "one"],
                [*do, "the", count, one, *noun, start, "of the", other, "one", on, further],
                [*do, "the", count, one, *noun, start],
                [*do, "the", count, one, *noun, start, on],
                [*do, "the", self._choose(NO_COUNTS), one, *noun, start, on, "the", other, "one"],
                [*do, "the", count, one, *noun, self._choose(NOWHERE), on, "the", other, "one"],
                [*do, "the", count, one, *noun, start, "or the", further, "one", on, "the", other],
                [*do, "the", count, one, *noun, "or the", further, "one", start, on, "the", other],
                [*do, "anything but the", count, one, *noun, start, on, "the", other, "one"],
                ["do not", *do, "the", count, one, *noun, start, on, "the", other, "one"],
                ["which is the", count, one, *noun, start],
                ["is the", count, one, *noun, start, on, "the", other, "one"],
                ["throw the", count, one, *noun, start, on, "the", other, "one"],
                [*do, "the", count, one, *noun, start, "to right", on, "the", other, "one"],
                [*do, "the", one, "one", count, on, "the", other, "one", "and", start],
                [*do, "the", count, "two", one, *noun, start, on, "the", other, "one"],
            ]
        )
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())

    def _step(self, counted: bool) -> Step:
        """A step in which one object or both may be counted; one certainly if `counted`."""
        action = self._choose([action.name for action in self._domain.actions])
        said = [self._described(is_counted=False) for _ in range(2)]
        if counted:
            for argument in self._rng.permutation(2)[: 1 if self._rng.random() > AGAIN else 2]:
                said[argument] = self._described(is_counted=True)
        return step_of(action, *said)

    def _described(self, is_counted: bool) -> Described:
        """One or two values of different types, or none if it is counted."""
        least = 0 if is_counted else 1
        number = int(self._rng.integers(least, 3))
        types = self._rng.permutation(len(self._domain.attributes))[:number]
        values = tuple(self._choose(self._domain.attributes[each].values).name for each in types)
        return Described(values, (), self._choose(self._ranked) if is_counted else None)

    def _apart(self) -> list[str]:
        """Values of three objects of which no two can be those of one."""
        attribute = self._domain.attributes[0]
        every = self._rng.permutation([value.name for value in attribute.values])
        return [self._choose(self._domain.concept(str(name)).words) for name in every[:3]]


class CountedDescriptions:
    """The descriptions of the blocks in an episode's initial scene that count them."""

    def __init__(self, domain: Domain, truth: Truth) -> None:
        self._extremes = ExtremeDescriptions(domain, truth)
        named = zip(domain.extremes, domain.extreme_words(), strict=True)
        keys = dict(named)
        #: The name of each extreme and the number, by what is counted.
        self._ranked = {name: (keys[of], rank) for name, (of, rank) in domain.ranked().items()}

    def of(self, block: int) -> list[Described]:
        """All descriptions of a block that clearly has a number among those that fit."""
        return [
            Described(kind, (), name)
            for kind, name, at, farther in self._numbered()
            if at == block and farther >= FARTHER_M
        ]

    def misleading(self) -> list[Described]:
        """Descriptions of two blocks that may have the number, and of more blocks than fit."""
        unclear = [
            Described(kind, (), name)
            for kind, name, _, farther in self._numbered()
            if farther <= SAME_M
        ]
        few = [
            Described(kind, (), name)
            for kind, order in self._extremes.ordered()
            for name, (of, rank) in self._ranked.items()
            if rank > len(order[of])
        ]
        return unclear + few

    def _numbered(self) -> Iterator[tuple[tuple[str, ...], str, int, float]]:
        """For all values that several blocks have, and what is counted: the block with this number,
        and how much farther it lies at least than the one before and the one behind it."""
        for kind, order in self._extremes.ordered():
            for name, (of, rank) in self._ranked.items():
                if rank <= len(order[of]):
                    reach = [distance for _, distance in order[of]]
                    gaps = -np.diff(reach)[max(rank - 2, 0) : rank]
                    yield kind, name, order[of][rank - 1][0], float(gaps.min())
