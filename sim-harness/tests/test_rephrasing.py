"""Phrases that are read as others: their texts, sentences with them, and near misses."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.rephrased import RephrasedSentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Program
from nsrm_harness.domain.recogniser import means_rewritten
from nsrm_harness.domain.rewriting import rephrasing_of
from nsrm_harness.evaluation.language import count, understand

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_texts_of_a_wording_file_are_all_those_that_its_rules_stand_for() -> None:
    table: dict[str, Any] = {
        "should be": ["is {supposed} to be"],
        "please": ["if you don't mind"],
        "rules": {"supposed": ["supposed", "meant"]},
    }
    assert rephrasing_of(table, "") == {
        "if you don't mind": "please",
        "is meant to be": "should be",
        "is supposed to be": "should be",
    }
    assert rephrasing_of({}, "") is None
    with pytest.raises(DomainError, match="no rule 'meant'"):
        rephrasing_of({"should be": ["is {meant} to be"]}, "words.toml")


@pytest.mark.parametrize(
    ("phrases", "problem"),
    [
        ({"is to be": "beneath"}, "rephrasing: 'beneath' is not a word of the grammar"),
        ({"": "please"}, "rephrasing: expected words"),
    ],
)
def test_what_no_phrase_can_be_read_as_is_refused(phrases: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["rephrasing"] = phrases
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


def test_sentences_say_most_phrases() -> None:
    sentences = RephrasedSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(2500)]
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    # Others are said with the order of steps: see test_sequences.py.
    phrases = [each for each in sentences.phrases() if DOMAIN.rephrasing[each] != "after putting"]
    # Those for what is rarely said come seldom.
    assert sum(f" {phrase} " in text for phrase in phrases) > 0.7 * len(phrases)
    assert all(means_rewritten(DOMAIN, sentence) for sentence, _ in told)
    assert sum(len(program) == 2 for _, program in told) > 500
    assert "  " not in text and "{" not in text


def test_the_built_in_model_understands_them_and_obeys_no_near_miss() -> None:
    sentences = RephrasedSentences(DOMAIN, np.random.default_rng(5))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(300)]
    right = count("other phrases", understand(model, told))
    assert right.wrong == 0 and right.right > 285, right
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(300)]
    assert count("no orders", understand(model, misses)).wrong == 0


def test_a_domain_without_phrases_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="no phrases"):
        RephrasedSentences(replace(DOMAIN, rephrasing={}), np.random.default_rng(0))
