"""Words that a sentence can do without: their texts, sentences with them, and near misses."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.wordy import OTHERWISE, WordySentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Program
from nsrm_harness.domain.recogniser import Recogniser
from nsrm_harness.domain.rewriting import simplification_of
from nsrm_harness.domain.tokens import Tokenizer, split
from nsrm_harness.evaluation.language import count, understand

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_lists_of_a_wording_file_have_all_that_their_rules_stand_for() -> None:
    table: dict[str, Any] = {
        "opening": {"": ["my {wish} is"]},
        "anywhere": {"": ["um"], "go": ["be moved"]},
        "rules": {"wish": ["wish", "request"]},
    }
    assert simplification_of(table, "") == {
        "opening": {"my request is": "", "my wish is": ""},
        "anywhere": {"be moved": "go", "um": ""},
        "closing": {},
        "connecting": {},
    }
    assert simplification_of({}, "") is None
    with pytest.raises(DomainError, match="no rule 'wish'"):
        simplification_of({"closing": {"": ["my {wish}"]}}, "words.toml")


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"closing": {"as it is": "beneath"}}, "simplification: 'beneath' is not a word"),
        ({"anywhere": {"": "please"}}, "simplification: expected words"),
        (
            {"taking": {"words": ["lift"], "towards": ["up"], "order": "toss", "object": "it"}},
            "simplification.taking: 'toss' is not a word of the grammar",
        ),
        (
            {"standing": {"clauses": ["that is"], "relations": ["left"], "read_as": "thing aloft"}},
            "simplification.standing: 'aloft' is not a word of the grammar",
        ),
        ({"connecting": {"and so": "and"}}, "simplification.connecting.and so: expected ''"),
    ],
)
def test_what_no_sentence_can_be_read_as_is_refused(change: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["simplification"] |= change
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


@pytest.mark.parametrize(
    ("sentence", "left"),
    [
        ("um , so first , please put the um , red on blue , could you", "put the red on blue"),
        ("put the , um , red on blue , um , then go", "put the red on blue , then go"),
        ("put red on blue , okay . then green on white", "put red on blue . then green on white"),
        ("1 : put red on blue 2) put green on white", "put red on blue , then put green on white"),
        ("so that it's on blue , put red", "so that it's on blue , put red"),
        ("put red so on blue", "put red so on blue"),
    ],
)  # fmt: skip
def test_what_is_left_is_what_the_core_reads(sentence: str, left: str) -> None:
    assert DOMAIN.simplification is not None and DOMAIN.ordinals is not None
    articles = DOMAIN.ordinals.articles
    assert " ".join(DOMAIN.simplification.simplified(split(sentence), articles)) == left
    model = nsrm.Model.pretrained()
    if "so on" not in sentence and "go" not in sentence:
        assert model.parse(sentence).notation == model.parse(left).notation


@pytest.mark.parametrize(
    ("sentence", "same"),
    [
        ("put the block which is behind the white one on the blue block",
         "put the block behind white on blue"),
        ("set the one that is on the red cube to the left of the small one",
         "put the one on red left of small"),
        ("put the green block on the table left of the white one", "put green left of white"),
        ("move the red block to the table", "put red on the table"),
        ("find the red block and put it on the blue one", "put red on blue"),
        ("put the white block that is of small size on the red one", "put white small on red"),
        ("put red on blue and only then green on red", "put red on blue then put green on red"),
        ("well , put red on blue . secondly , move the green block , um , on red",
         "put red on blue then put green on red"),
        ("put red on blue when you are done putting green on white",
         "put green on white then put red on blue"),
        ("put red on blue prior to putting green on white",
         "put red on blue then put green on white"),
    ],
)  # fmt: skip
def test_other_words_mean_the_same(sentence: str, same: str) -> None:
    model = nsrm.Model.pretrained()
    assert model.parse(sentence).notation == model.parse(same).notation


def test_a_further_step_that_is_said_to_be_the_first_is_refused() -> None:
    model = nsrm.Model.pretrained()
    for first in ("first", "firstly", "to begin", "to begin with", "please first"):
        with pytest.raises(nsrm.Refused):
            model.parse(f"um , put red on blue , and {first} put green on the white block")


def test_a_command_is_recognised_without_what_it_can_do_without() -> None:
    recogniser, tokenizer = Recogniser.of(DOMAIN), Tokenizer(DOMAIN)
    words = tokenizer("put please the red block kindly on the blue one now then").words
    assert recogniser.command(words) and not recogniser.program(words)
    assert not recogniser.command(tokenizer("put then the red block on the blue one").words)


def test_sentences_have_such_words_and_keep_their_meaning() -> None:
    sentences = WordySentences(DOMAIN, np.random.default_rng(3))
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(600)]
    text = " ".join(sentence for sentence, _ in told)
    assert "{" not in text and "  " not in text
    outcome = count("wordy", understand(nsrm.Model.pretrained(), told))
    assert outcome.wrong == 0 and outcome.right > 540, outcome


def test_the_built_in_model_obeys_no_near_miss() -> None:
    sentences = WordySentences(DOMAIN, np.random.default_rng(5))
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(600)]
    begun = {sentence.split()[0] for sentence, _ in misses}
    assert len(begun) > len(OTHERWISE) // 3
    assert count("no orders", understand(nsrm.Model.pretrained(), misses)).wrong == 0


def test_a_domain_that_leaves_nothing_out_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="no words"):
        WordySentences(replace(DOMAIN, simplification=None), np.random.default_rng(0))
