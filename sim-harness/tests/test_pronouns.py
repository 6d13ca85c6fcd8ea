"""Pronouns, "… and put the green block on it": said for what the step before moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.pronouns import with_pronoun, without_meaning
from nsrm_harness.domain.everyday import PRONOUN, Speaker, with_everyday
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.evaluation.language import say_pronouns

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))
SAID = (PRONOUN,)
PROGRAM = (
    Step("MoveOn", ("red", "small"), ("blue",)),
    Step("MoveLeft", ("green",), ("white",)),
    Step("MoveOn", ("blue",), ("lego",)),
)


def test_the_wording_has_pronouns_that_are_words() -> None:
    assert DOMAIN.pronouns["it"] == "" and DOMAIN.pronouns["its"] == "one's"
    assert {*DOMAIN.pronouns, "one's"} <= DOMAIN.other_words()


def test_a_pronoun_stands_for_what_the_step_before_moves() -> None:
    rng = np.random.default_rng(3)
    seen = set[tuple[int, str]]()
    for _ in range(100):
        pair = with_pronoun(PROGRAM, rng)
        assert pair is not None
        said, meant = pair
        (at,) = (index for index, step in enumerate(said) if SAID in (step.object, step.reference))
        argument = "object" if said[at].object == SAID else "reference"
        assert meant[at] == replace(said[at], **{argument: PROGRAM[at - 1].object})
        assert [*said[:at], *said[at + 1 :]] == [*PROGRAM[:at], *PROGRAM[at + 1 :]]
        assert [*meant[:at], *meant[at + 1 :]] == [*PROGRAM[:at], *PROGRAM[at + 1 :]]
        seen.add((at, argument))
    assert seen == {(at, argument) for at in (1, 2) for argument in ("object", "reference")}
    same = (PROGRAM[0], Step("MoveOn", ("small", "red"), ("small", "red")))
    assert with_pronoun(same, rng) is None


def is_meaningless(program: Program) -> bool:
    for before, step in zip((None, *program[:-1]), program, strict=True):
        arguments = [step.object, step.reference]
        if SAID in arguments:
            other = arguments[1 - arguments.index(SAID)]
            return before is None or other in (SAID, before.object)
    return False


def test_a_pronoun_without_a_meaning_has_none() -> None:
    rng = np.random.default_rng(4)
    for program in (PROGRAM, PROGRAM[:1]):
        assert all(is_meaningless(without_meaning(program, rng)) for _ in range(100))


def test_pronouns_are_said_and_never_before_values() -> None:
    speaker, tokenizer = Speaker(DOMAIN, np.random.default_rng(5)), Tokenizer(DOMAIN)
    words = set[str]()
    for step in (Step("MoveLeft", SAID, ("red",)), Step("MoveLeft", ("red",), SAID)):
        for _ in range(300):
            said = speaker.sentence((PROGRAM[0], step))
            assert len(tokenizer(" ".join(said)).groups) == 3
            words.update(said)
    assert set(DOMAIN.pronouns) <= words and PRONOUN not in words
    none = Speaker(replace(DOMAIN, pronouns={"it": ""}), np.random.default_rng(5))
    said = [none.sentence((PROGRAM[0], Step("MoveLeft", ("red",), SAID))) for _ in range(100)]
    assert all("it" in words for words in said)


@pytest.mark.parametrize("seed", [0, 1])
def test_sentences_with_pronouns_are_told_apart_by_their_wording(seed: int) -> None:
    sets = say_pronouns(DOMAIN, [PROGRAM, PROGRAM[:1]] * 20, seed)
    assert sets.keys() == {"pronouns", "pronouns held out", "pronouns of nothing"}
    told = [program for name in ("pronouns", "pronouns held out") for _, program in sets[name]]
    assert len(told) == len(sets["pronouns of nothing"]) == 60
    assert all(program is not None and len(program) == 3 for program in told)
    assert all(program is None for _, program in sets["pronouns of nothing"])
