"""Says commands with words that they can do without, "um, so first, could you please put …"; and
near misses, in which such words order nothing, or others change what is said."""

from __future__ import annotations

import numpy as np

from nsrm_harness.data.draws import Draws
from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import everyday_of
from nsrm_harness.domain.program import Program

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: Most words that are inserted between others.
MOST_INSERTED = 1
#: Words before which people pause.
PAUSES = ("and", "then", ",")
#: What has such words and orders nothing, or not this.
OTHERWISE = (
    "so , {moved} is {relation}", "good , {moved} is {relation} , thanks",
    "robot , {moved} was {relation}", "um , never {do} {moved} {relation}",
    "please don't {do} {moved} {relation}", "please do not {do} {moved} {relation} , thanks",
    "would you {do} {moved} , please", "could you please {do}", "so , {relation} , please",
    "if you {do} {moved} {relation} , thanks", "ok , you could {do} {moved}",
    "you should not {do} {moved} {relation} , please", "please , um , {moved} , thanks",
    "thanks , you {done} {moved} {relation}", "should you {do} {moved} {relation}",
    "please , almost {do} {moved} {relation}", "well , {moved} must not go {relation}",
    "could you see that {moved} was {relation}", "now , is {moved} {relation} , please",
    "um , {do} {moved} {relation} unless it is red", "ok , i {done} {moved} {relation}",
    "why would you {do} {moved} {relation}", "how would you {do} {moved} {relation}",
    "you can not {do} {moved} {relation}", "would you ever {do} {moved} {relation}",
    "please {do} {moved} {relation} or not", "can {moved} be {relation}",
    "could you have {done} {moved} {relation} , please", "did you {do} {moved} {relation}",
    "thanks , robot", "um", "first , please , thank you", "step 1 :", "task : , please",
)  # fmt: skip


class WordySentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        lists = domain.simplification
        if lists is None:
            raise ValueError("the domain's wording has no words that a sentence can do without")
        super().__init__(domain, rng)
        self._opening, self._anywhere, self._closing = (
            [text for text, read_as in phrases.items() if not read_as]
            for phrases in (lists.opening, lists.anywhere, lists.closing)
        )
        self._verbs = {*everyday_of(domain).rules["do"]}

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        program: Program = (self._step(),)
        if self._rng.random() < FOLLOWED:
            program = (*program, self._step())
        steps = self._speaker.steps(program)
        words = [word for step in steps for word in step]
        for _ in range(int(self._rng.integers(MOST_INSERTED + 1))):
            # Where people pause.
            places = [at + 1 for at, word in enumerate(words) if word in self._verbs]
            places += [at for at, word in enumerate(words) if word in PAUSES]
            if places:
                at = self._choose(places)
                words[at:at] = self._choose(self._anywhere).split()
        if self._rng.random() < 0.5:
            words = [*self._choose(self._opening).split(), *words]
        if self._rng.random() < 0.5:
            words = [*words, *self._choose(self._closing).split()]
        return " ".join(words), program

    def near_miss(self) -> str:
        """A sentence that must be refused."""
        words = self._choose(OTHERWISE).replace("{done}", "moved")
        return " ".join(self._speaker.words(words, self._step()))
