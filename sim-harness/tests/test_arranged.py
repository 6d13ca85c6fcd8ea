"""Towers and rows: how the wording says them, and sentences about them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.arranged import ArrangedSentences, program_of
from nsrm_harness.data.draws import LEAST, MOST
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Step
from nsrm_harness.domain.rewriting import ArrangedStep, expanded

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))
TABLE = {
    "between": ["and"],
    "ends": ["then", "{do}"],
    "next": "then",
    "steps": {
        "up": {"action": "MoveOn", "order": "put", "relation": "on"},
        "back": {"action": "MoveBehind", "order": "put", "relation": "behind"},
    },
    "patterns": [
        {"openings": ["{build} a {tower} of", "stack"], "closings": {"": "up", "{way}": "up"}},
        {"openings": ["line up"], "closings": {"from front to back": "back"}},
    ],
    "rules": {
        "build": ["build", "make"],
        "tower": ["tower", "{pile}"],
        "pile": ["pile"],
        "way": ["up"],
    },
}
RULES = {"do": ["put", "set down"]}


def test_rules_stand_for_texts() -> None:
    table = expanded(TABLE, ["MoveOn", "MoveBehind"], RULES, "words.toml")
    assert table is not None and "rules" not in table
    assert table["ends"] == ["put", "set", "then"]
    tower, row = table["patterns"]
    texts = [f"{build} a {pile} of" for build in ("build", "make") for pile in ("pile", "tower")]
    assert tower == {"openings": [*texts, "stack"], "closings": {"": "up", "up": "up"}}
    assert row["closings"] == {"from front to back": "back"}


def test_what_the_domain_has_no_action_for_is_left_out() -> None:
    table = expanded(TABLE, ["MoveOn"], RULES, "words.toml")
    assert table is not None
    assert len(table["patterns"]) == 1 and [*table["steps"]] == ["up"]
    assert expanded(TABLE, ["MoveLeft"], RULES, "words.toml") is None
    assert expanded({}, ["MoveOn"], RULES, "words.toml") is None


def test_a_rule_that_contains_itself_is_named() -> None:
    looping = {**TABLE, "rules": {**TABLE["rules"], "pile": ["{tower}"]}}
    with pytest.raises(DomainError, match=r"no rule 'tower'; add it to arrangements\.rules"):
        expanded(looping, ["MoveOn"], RULES, "words.toml")


def test_each_object_is_put_in_relation_to_the_one_before() -> None:
    up = ArrangedStep("MoveOn", "put", "on")
    objects = (("red",), ("small", "green"), ("blue",))
    green_on_red = Step("MoveOn", ("small", "green"), ("red",))
    blue_on_green = Step("MoveOn", ("blue",), ("small", "green"))
    assert program_of(up, objects) == (green_on_red, blue_on_green)
    assert program_of(replace(up, reversed=True), objects[::-1]) == (green_on_red, blue_on_green)


def test_sentences_use_all_that_the_wording_has() -> None:
    said = DOMAIN.arrangements
    assert said is not None
    sentences = ArrangedSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(2000)]
    counts = {len(program) for _, program in told}
    assert counts == {*range(LEAST - 1, MOST + 1)}
    actions = {step.action for _, program in told for step in program}
    assert actions == {action.name for action in DOMAIN.actions}
    text = " | ".join(sentence for sentence, _ in told)
    for pattern in said.patterns:
        missing = [each for each in pattern.closings if each not in text]
        assert not missing
    assert "  " not in text and "{" not in text


def test_near_misses_are_none_of_the_sentences() -> None:
    sentences = ArrangedSentences(DOMAIN, np.random.default_rng(4))
    misses = [sentences.near_miss() for _ in range(500)]
    for words in (" or ", " and not ", "do not ", "unless you ", " all "):
        assert sum(words in f" {each} " for each in misses) > 20, words


def test_a_domain_without_them_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="no towers and rows"):
        ArrangedSentences(replace(DOMAIN, arrangements=None), np.random.default_rng(0))
