"""What those have in common that draw sentences of one domain, about no scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import Speaker
from nsrm_harness.domain.program import Step

Values = tuple[str, ...]
_T = TypeVar("_T")
#: Number of objects in a list: at least and at most.
LEAST, MOST = 2, 5
#: Share of lists whose noun is said once, in the plural: "the red, green and blue blocks".
PLURAL = 0.3
#: How the objects of a list are joined: between them, and before the last one.
Joint = tuple[str, str]
JOINTS: tuple[Joint, ...] = (
    (" , ", " and "),
    (" , ", " , and "),
    (" and ", " and "),
    (" , ", " , "),
)


class Draws:
    """Draws plain steps and what they are about."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        self._domain, self._rng = domain, rng
        self._speaker = Speaker(domain, rng)

    def _step(self) -> Step:
        action = self._choose(self._domain.actions)
        return Step(action.name, self._values(), self._values())

    def _values(self) -> Values:
        """One or two, of different types."""
        types = self._rng.permutation(len(self._domain.attributes))[: int(self._rng.integers(1, 3))]
        return tuple(self._choose(self._domain.attributes[each].values).name for each in types)

    def _choose(self, every: Sequence[_T]) -> _T:
        return every[int(self._rng.integers(len(every)))]


class ListDraws(Draws):
    """Draws lists of objects, too."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.several is None:
            raise ValueError("the domain's wording has no plurals")
        super().__init__(domain, rng)
        self._nouns = [*domain.several.plurals]

    def _objects(self) -> tuple[Values, ...]:
        """Descriptions of different objects."""
        count, objects = int(self._rng.integers(LEAST, MOST + 1)), list[Values]()
        while len(objects) < count:
            values = self._values()
            if all({*values} != {*other} for other in objects):
                objects.append(values)
        return tuple(objects)

    def _list(self, objects: tuple[Values, ...]) -> list[str]:
        """The words of a list of these objects."""
        if self._rng.random() < PLURAL:
            *before, last = [" ".join(values) for values in objects]
            items = [f"the {before[0]}", *before[1:], f"{last} {self._choose(self._nouns[2:])}"]
        else:
            items = [" ".join(self._described(values)) for values in objects]
        between, before_last = self._choose(JOINTS)
        return f"{between.join(items[:-1])}{before_last}{items[-1]}".split()

    def _described(self, values: Values) -> list[str]:
        return self._speaker.words("{moved}", Step(self._domain.actions[0].name, values, ()))

    def _before(self) -> list[str]:
        return self._speaker.words("{before}")
