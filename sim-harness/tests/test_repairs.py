"""What a speaker takes back or rules out: what is said of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.repairs import RepairSentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.rewriting import repairs_of

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_texts_of_a_wording_file_are_all_those_that_its_rules_stand_for() -> None:
    table: dict[str, Any] = {
        "corrections": ["{oh}no", "no"],
        "exclusions": ["not"],
        "rules": {"oh": ["", "oh "]},
    }
    assert repairs_of(table, "") == {"corrections": ["no", "oh no"], "exclusions": ["not"]}
    assert repairs_of({}, "") is None
    with pytest.raises(DomainError, match=r"wording: repairs: no rule 'oh'.* repairs\.rules"):
        repairs_of({"corrections": ["{oh}no"]}, "wording")


def test_sentences_take_back_and_rule_out_either_object() -> None:
    assert DOMAIN.repairs is not None
    sentences = RepairSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    for each in (*DOMAIN.repairs.exclusions, "no", "sorry", "i mean", "no , wait"):
        assert f" {each} " in text, each
    assert sum(len(program) == 2 for _, program in told) > 300
    assert {step.action for _, (step, *_) in told} == {each.name for each in DOMAIN.actions}
    assert "  " not in text and "{" not in text


def test_near_misses_leave_open_what_is_meant() -> None:
    sentences = RepairSentences(DOMAIN, np.random.default_rng(4))
    text = " | ".join(sentences.near_miss() for _ in range(500))
    for each in ("do not", "neither the", "anything but", "don't", "throw", "is the"):
        assert each in text, each
    assert "  " not in text and "{" not in text
