"""Two steps in another order than that in which they are carried out: what is said of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nsrm_harness import domain as domains
from nsrm_harness.data.sequences import OTHERWISE, SequenceSentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.recogniser import means_rewritten
from nsrm_harness.domain.rewriting import sequence_of

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_texts_of_a_wording_file_are_all_those_that_its_rules_stand_for() -> None:
    table: dict[str, Any] = {
        "later": {"before {putting}": "put"},
        "earlier": {"after you": ""},
        "afterthoughts": ["but {first}"],
        "next": ", then",
        "rules": {"putting": ["putting", "placing"], "first": ["first", "before that"]},
    }
    assert sequence_of(table, "") == {
        "later": {"before putting": "put", "before placing": "put"},
        "earlier": {"after you": ""},
        "afterthoughts": ["but before that", "but first"],
        "next": ", then",
    }
    assert sequence_of({}, "") is None


def test_sentences_say_both_orders_in_all_ways() -> None:
    assert DOMAIN.sequence is not None
    sentences = SequenceSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    assert all(f" {each} " in text for each in DOMAIN.sequence.said())
    assert all(len(program) == 2 for _, program in told)
    assert "  " not in text and "{" not in text


def test_near_misses_have_no_such_order() -> None:
    sentences = SequenceSentences(DOMAIN, np.random.default_rng(4))
    text = f" {' | '.join(sentences.near_miss() for _ in range(1500))} "
    for each in (*OTHERWISE, "did you", "do not", ". then", "when"):
        assert f" {each} " in text, each
    assert "  " not in text and "{" not in text


def test_what_says_an_order_is_no_nonsense() -> None:
    meant = "put red on blue after you put green on white"
    assert means_rewritten(DOMAIN, meant)
    assert not means_rewritten(replace(DOMAIN, sequence=None), meant)
    assert not means_rewritten(DOMAIN, "put red on blue , first put green on white")
