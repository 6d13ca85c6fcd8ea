"""Points of view: their texts, sentences from them, and near misses."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.perspectives import PerspectiveSentences
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Program
from nsrm_harness.domain.rewriting import perspectives_of
from nsrm_harness.evaluation.language import count, understand

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_a_domain_has_the_opposites_of_its_actions() -> None:
    table: dict[str, Any] = {
        "own": ["from my {view}"],
        "other": ["from there"],
        "opposites": {"MoveLeft": "MoveRight", "MoveRight": "MoveLeft", "MoveUp": "MoveDown"},
        "rules": {"view": ["view", "side"]},
    }
    assert perspectives_of(table, ["MoveLeft", "MoveRight"], "") == {
        "own": ["from my side", "from my view"],
        "other": ["from there"],
        "opposites": {"MoveLeft": "MoveRight", "MoveRight": "MoveLeft"},
    }
    # Whose left would be meant?
    assert perspectives_of(table, ["MoveLeft"], "") is None
    assert perspectives_of({}, ["MoveLeft"], "") is None


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"own": [""]}, "perspectives: expected words"),
        ({"opposites": {"MoveUp": "MoveUp"}}, "perspectives.opposites.MoveUp: no such action"),
        (
            {"opposites": {"MoveLeft": "MoveRight"}},
            "perspectives.opposites.MoveLeft: is not the opposite of MoveRight",
        ),
    ],
)
def test_perspectives_of_no_opposites_are_refused(change: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["perspectives"] |= change
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


def test_the_built_in_model_turns_directions_round_and_obeys_no_near_miss() -> None:
    model = nsrm.Model.pretrained()
    said = "put the leftmost block in front of the one to the right of the red one"
    turned = "put the rightmost block behind the one to the left of the red one"
    from_there = model.parse(f"{said}, from the robot's point of view")
    assert from_there.notation == model.parse(turned).notation
    assert model.parse(f"as i see it, {said}").notation == model.parse(said).notation
    sentences = PerspectiveSentences(DOMAIN, np.random.default_rng(5))
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(300)]
    outcome = count("points of view", understand(model, told))
    assert outcome.wrong == 0 and outcome.right > 285, outcome
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(300)]
    assert count("no points of view", understand(model, misses)).wrong == 0


def test_a_domain_without_perspectives_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="no points of view"):
        PerspectiveSentences(replace(DOMAIN, perspectives=None), np.random.default_rng(0))
