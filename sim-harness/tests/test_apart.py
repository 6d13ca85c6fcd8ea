"""Values that stand apart, "the small block that is red", in sentences about programs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.apart import ApartSentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Step

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))
PROGRAM = (
    Step("MoveOn", ("red", "small"), ("blue",)),
    Step("MoveLeft", ("cyan", "lego"), ("red",)),
)


def test_values_stand_apart_in_all_ways_of_the_wording() -> None:
    apart = DOMAIN.apart
    assert apart is not None
    sentences = ApartSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw(PROGRAM) for _ in range(600)]
    assert all(told)
    text = " | ".join(f" {each} " for each in told)
    for phrase in (*apart.between, *apart.phrases):
        assert f" {phrase} " in text, phrase
    # In each of both steps.
    assert all(
        " red small " not in f" {each} " and " lego cyan " not in f" {each} " for each in told
    )


def test_a_program_with_single_values_is_not_said_apart() -> None:
    sentences = ApartSentences(DOMAIN, np.random.default_rng(3))
    single = (Step("MoveOn", ("red",), ("blue",)),)
    assert all(sentences.draw(single) is None for _ in range(50))
    assert all(sentences.near_miss(single) is None for _ in range(50))


def test_near_misses_have_two_values_of_one_type() -> None:
    sentences = ApartSentences(DOMAIN, np.random.default_rng(4))
    lexicon = DOMAIN.lexicon()
    program = (Step("MoveOn", ("red", "small"), ("blue",)),)
    for _ in range(200):
        miss = sentences.near_miss(program)
        assert miss is not None
        values = [DOMAIN.concepts[lexicon[word]] for word in miss.split() if word in lexicon]
        values.remove(DOMAIN.concept("blue"))
        first, second = values
        assert first.attribute == second.attribute and first != second, miss


def test_a_domain_without_it_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="nothing between values"):
        ApartSentences(replace(DOMAIN, apart=None), np.random.default_rng(0))
