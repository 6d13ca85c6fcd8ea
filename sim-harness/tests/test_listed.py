"""Lists of objects that are moved: sentences with them, and near misses."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.listed import ListedSentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Program
from nsrm_harness.domain.recogniser import means_list, means_rewritten
from nsrm_harness.evaluation.language import count, understand

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"next": "whereupon"}, "lists.next: 'whereupon' is not a word of the grammar"),
        ({"them": ["", "them"]}, "lists: expected words"),
    ],
)
def test_a_list_that_cannot_be_read_is_refused(change: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["lists"] |= change
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


@pytest.mark.parametrize(
    ("sentence", "meant"),
    [
        ("put red and blue on green", True),
        ("put the red one , the small block and blue left of green", True),
        ("pick up the red block as well as the blue one and put them on green", True),
        ("put red on blue and green on white", False),
        ("put the red block , the blue one on green", False),
        ("red and blue on green", False),
    ],
)
def test_a_list_is_recognised_behind_its_verb(sentence: str, meant: bool) -> None:
    assert means_list(DOMAIN, sentence) == meant
    assert means_rewritten(DOMAIN, sentence) == meant
    assert not means_list(replace(DOMAIN, lists=None), sentence)


def test_the_built_in_model_moves_each_of_them_and_obeys_no_near_miss() -> None:
    sentences = ListedSentences(DOMAIN, np.random.default_rng(5))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(400)]
    assert {len(program or ()) for _, program in told} >= {2, 3, 4}
    outcome = count("lists", understand(model, told))
    assert outcome.wrong == 0 and outcome.right > 375, outcome
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(400)]
    assert count("no lists", understand(model, misses)).wrong == 0


def test_a_domain_without_lists_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="lists no objects"):
        ListedSentences(replace(DOMAIN, lists=None), np.random.default_rng(0))
