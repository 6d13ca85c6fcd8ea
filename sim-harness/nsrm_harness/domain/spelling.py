"""How words are misspelt."""

from __future__ import annotations

import string
from collections.abc import Sequence

import numpy as np

from nsrm_harness.domain.domain import Domain

#: Letters of the shortest words that the core takes for misspelt ones.
LEAST_LETTERS = 3
#: Letters of the shortest words that are misspelt in tests.
LEAST_MISSPELT = 4


def one_edit(word: str) -> set[str]:
    """What one letter omitted, added, changed or swapped with its neighbour makes of a word."""
    cuts = [(word[:at], word[at:]) for at in range(len(word) + 1)]
    made = {before + behind[1:] for before, behind in cuts if behind}
    made |= {before + behind[1::-1] + behind[2:] for before, behind in cuts if len(behind) > 1}
    for letter in string.ascii_lowercase:
        made |= {before + letter + behind for before, behind in cuts}
        made |= {before + letter + behind[1:] for before, behind in cuts if behind}
    return {other for other in made - {word} if other.isalpha() and len(other) >= LEAST_LETTERS}


class Misspeller:
    """Misspells words of one domain, so that they are neither its own nor in its dictionary."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        self._rng = rng
        self._real = domain.known_words()
        if domain.spelling is not None:
            self._real |= {*domain.spelling.other_words, *domain.spelling.heard}

    def has_choice(self, words: Sequence[str]) -> bool:
        """Whether a word is long enough."""
        return any(len(word) >= LEAST_MISSPELT for word in words)

    def __call__(self, words: Sequence[str]) -> list[str]:
        """The words, one of four letters or more misspelt."""
        places = [at for at, word in enumerate(words) if len(word) >= LEAST_MISSPELT]
        place = places[int(self._rng.integers(len(places)))]
        made = sorted(one_edit(words[place]) - self._real)
        misspelt = made[int(self._rng.integers(len(made)))]
        return [*words[:place], misspelt, *words[place + 1 :]]
