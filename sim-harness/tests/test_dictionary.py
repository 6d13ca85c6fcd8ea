"""Words of a dictionary are never taken for misspelt ones."""

from __future__ import annotations

import json

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.domain.dictionary import with_dictionary
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.spelling import Misspeller, one_edit

DOMAIN = with_dictionary(with_everyday(domains.load()))


def test_edits_by_hand() -> None:
    made = one_edit("the")
    assert {"he", "te", "th", "hte", "teh", "then", "tie", "thee", "athe"} & made == {
        "hte",
        "teh",
        "then",
        "tie",
        "thee",
        "athe",
    }
    assert "the" not in made and len(made) == 4 * 26 + 3 * 25 + 2 - 3


def test_words_of_the_dictionary_are_other_words() -> None:
    spelling = DOMAIN.spelling
    assert spelling is not None
    others = {*spelling.other_words}
    assert {"black", "blocks", "not", "reds", "pink", "dont", "wont"} <= others
    assert not others & {*DOMAIN.known_words(), *spelling.heard, "yelow", "teh", "plase"}
    assert others == {*domains.from_json(DOMAIN.as_json(), "test").spelling.other_words}  # type: ignore[union-attr]
    assert 1500 < len(others) < 4000
    # What is done twice changes nothing.
    assert with_dictionary(DOMAIN).as_json() == DOMAIN.as_json()


@pytest.mark.parametrize("language", ["de", None])
def test_the_dictionary_is_that_of_the_language(language: str | None) -> None:
    document = json.loads(with_everyday(domains.load()).as_json())
    document["spelling"]["language"] = language
    if language is None:
        del document["spelling"]["language"]
    domain = with_dictionary(domains.parse(document, "test"))
    assert domain.spelling is not None
    others = domain.spelling.other_words
    assert ("und" in others) == (language == "de")


def test_misspelt_words_are_no_words() -> None:
    misspelt = Misspeller(DOMAIN, np.random.default_rng(3))
    assert DOMAIN.spelling is not None
    real = {*DOMAIN.known_words(), *DOMAIN.spelling.other_words}
    words = ["put", "the", "small", "red", "block", "on", "the", "yellow", "one"]
    for _ in range(200):
        (changed,) = [word for word in misspelt(words) if word not in words]
        assert changed not in real and any(changed in one_edit(word) for word in words)
