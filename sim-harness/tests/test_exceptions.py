"""What is left out of a description: its words, sentences that say it, and which blocks then
move."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.exceptions import ExceptionSentences, excepted_programs
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import ALL, Excepted, Program, Step, canonical
from nsrm_harness.domain.rewriting import exceptions_of
from nsrm_harness.evaluation.language import count, understand
from nsrm_harness.geometry.pose import Pose

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_texts_of_a_wording_file_are_all_those_that_its_rules_stand_for() -> None:
    table: dict[str, Any] = {
        "phrases": ["except"],
        "negations": ["{that} not"],
        "rules": {"that": ["that is", "which is"]},
    }
    assert exceptions_of(table, "") == {
        "phrases": ["except"],
        "negations": ["that is not", "which is not"],
    }
    assert exceptions_of({}, "") is None


@pytest.mark.parametrize("key", ["phrases", "negations"])
def test_an_empty_text_is_refused(key: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["exceptions"][key] = [""]
    with pytest.raises(DomainError, match="exceptions: expected words"):
        domains.parse(document, "test")


def test_sentences_leave_out_in_all_ways() -> None:
    sentences = ExceptionSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    steps = [program[0] for _, program in told]
    left_out = [step.object_except or step.reference_except for step in steps]
    assert all(each is not None and each.values for each in left_out)
    assert {each.which for each in left_out if each is not None} == {None, ALL}
    assert {step.object_which for step in steps} == {None, ALL}
    assert DOMAIN.exceptions is not None
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    said = (*DOMAIN.exceptions.phrases, *DOMAIN.exceptions.negations)
    assert all(f" {each} " in text for each in said)
    assert " everything " in text
    assert "  " not in text and "{" not in text
    assert sum(len(program) == 2 for _, program in told) > 300


def test_the_built_in_model_understands_them_and_refuses_near_misses() -> None:
    sentences = ExceptionSentences(DOMAIN, np.random.default_rng(5))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(300)]
    right = count("exceptions", understand(model, told))
    assert right.wrong == 0 and right.right > 290, right
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(300)]
    assert count("no exceptions", understand(model, misses)).wrong == 0


def test_programs_with_other_exceptions_differ() -> None:
    step = Step("MoveOn", (), ("blue",), object_which=ALL)
    one, any_number = (Excepted(("red", "small"), which) for which in (None, ALL))
    programs = [replace(step, object_except=each) for each in (None, one, any_number)]
    programs.append(replace(step, reference_except=one))
    assert len({canonical([each]) for each in programs}) == 4
    for each in programs:
        assert Step.from_json(each.as_json()) == each
    assert "except" not in programs[0].as_json()["object"]
    swapped = replace(step, object_except=Excepted(("small", "red")))
    assert canonical([swapped]) == canonical([programs[1]])


def test_a_domain_without_exceptions_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="leaves nothing out"):
        ExceptionSentences(replace(DOMAIN, exceptions=None), np.random.default_rng(0))


def test_all_blocks_of_a_kind_but_the_one_that_is_left_out_are_moved() -> None:
    values = (("red", "small"), ("green", "small"), ("red", "lego"), ("blue", "lego"))
    truth = SimpleNamespace(
        attributes=[{"color": color, "size": size} for color, size in values],
        initial_poses=tuple(
            Pose((0.4, 0.1 * index, 0.02), (0.0, 0.0, 0.0, 1.0)) for index in range(4)
        ),
        edges_m=np.full((4, 3), 0.04),
    )
    rng = np.random.default_rng(1)
    true, untrue = excepted_programs(DOMAIN, cast(Truth, truth), rng, 200)
    assert len(true) == len(untrue) == 200
    for each in true:
        (step,) = each.program
        assert step.object_except is not None and step.object_except.which is None
        fits = [
            index + 1
            for index, own in enumerate(values)
            if {*step.object} <= {*own} and index + 1 != each.reference
        ]
        left_out = {*step.object_except.values}
        assert each.moved == tuple(at for at in fits if not left_out <= {*values[at - 1]})
    for each in untrue:
        (step,) = each.program
        assert step.object_except is not None
        among = [own for own in values if {*step.object, *step.object_except.values} <= {*own}]
        assert len(among) != 1 and not each.moved
