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
