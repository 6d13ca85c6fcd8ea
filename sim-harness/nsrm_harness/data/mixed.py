"""Programs of many steps that mix all that descriptions may have: relations, extremes, and pronouns
for what the step before moved. They are about no scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nsrm_harness.data.pronouns import with_pronoun_at
from nsrm_harness.data.relations import Described, step_of
from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import everyday_of
from nsrm_harness.domain.program import Program, Relation, Step

#: Share of descriptions with a relation, and of those with an extreme; the others are plain.
RELATED, EXTREME = 0.2, 0.1
#: Share of the descriptions with a relation that have no values of their own.
BARE = 0.3
#: Share of later steps with a pronoun.
REFERRING = 0.2
#: The action on whose state nothing else is put: demonstrations show no place beside it.
ON = "MoveOn"


class MixedPrograms:
    """Draws programs of one domain with everyday wording."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        self._domain = domain
        self._rng = rng
        self._states = list(everyday_of(domain).states())
        self._extremes = list(domain.extreme_words())

    def draw(self, steps: int) -> tuple[Program, Program]:
        """A program as it is said, and what it means."""
        said: list[Step] = []
        meant: list[Step] = []
        while len(said) < steps:
            step = self._step()
            spoken, plain = step, step
            if meant and self._domain.pronouns and self._rng.random() < REFERRING:
                pair = with_pronoun_at(step, meant[-1], self._rng)
                if pair is None:
                    continue
                spoken, plain = pair
            said.append(spoken)
            meant.append(plain)
        return tuple(said), tuple(meant)

    def _step(self) -> Step:
        action = self._choose([action.name for action in self._domain.actions])
        names = [name for name in self._states if action == ON or name != ON]
        return step_of(action, self._described(self._states), self._described(names))

    def _described(self, names: Sequence[str]) -> Described:
        """With a relation of these names, an extreme, or plain."""
        draw, values = self._rng.random(), self._values()
        if names and draw < RELATED:
            relation = Relation(self._choose(names), self._values())
            return Described(() if self._rng.random() < BARE else values, (relation,))
        if self._extremes and draw > 1.0 - EXTREME:
            return Described(values, (), self._choose(self._extremes))
        return Described(values, ())

    def _values(self) -> tuple[str, ...]:
        """One or two, of different types."""
        types = self._rng.permutation(len(self._domain.attributes))[: int(self._rng.integers(1, 3))]
        values = [self._domain.attributes[each].values for each in types]
        return tuple(each[int(self._rng.integers(len(each)))].name for each in values)

    def _choose(self, names: Sequence[str]) -> str:
        return names[int(self._rng.integers(len(names)))]
