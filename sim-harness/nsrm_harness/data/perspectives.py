"""Says commands from a point of view, "from the robot's point of view, put the red block to the
left of the blue one"; and near misses, from that of nobody."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nsrm_harness.data.draws import Draws
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import Program, Step

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: Points of view of nobody, and what is like one.
NOBODY = (
    "from her point of view", "from the red block's point of view", "as seen from behind",
    "as they see it", "from the camera's side", "from no point of view", "from above",
    "from another perspective", "as she sees it", "from where it is", "as i said",
)  # fmt: skip


class PerspectiveSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.perspectives is None:
            raise ValueError("the domain's wording has no points of view")
        super().__init__(domain, rng)
        self._said = domain.perspectives

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        program: Program = (self._step(),)
        if self._rng.random() < FOLLOWED:
            program = (*program, self._step())
        words = " ".join(self._speaker.sentence(program))
        own = self._rng.random() < 0.3
        text = self._choose(self._said.own if own else self._said.other)
        meant = program if own else tuple(self._turned(step) for step in program)
        return self._with(words, text), meant

    def near_miss(self) -> str:
        """A sentence that must be refused."""
        words = " ".join(self._speaker.words("{before} {command}", self._step()))
        own, other = self._choose(self._said.own), self._choose(self._said.other)
        return self._choose(
            [
                self._with(words, self._choose(NOBODY)),
                self._with(words, self._choose(NOBODY)),
                f"{own} , {words} , {other}",
                f"{other} , {words} , {own}",
                f"{other} , is {words}",
                f"{other} , the red block is on the blue one",
                f"{other} , do not {words}",
                f"what is {other}",
                other,
            ]
        )

    def _with(self, words: str, text: str) -> str:
        return self._choose([f"{text} , {words}", f"{text} {words}", f"{words} , {text}"])

    def _turned(self, step: Step) -> Step:
        return replace(step, action=self._said.opposites.get(step.action, step.action))
