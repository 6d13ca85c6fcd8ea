"""What is put or lies between two objects: sentences about it, near misses, and in scenes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.data.between import BetweenSentences, between_programs
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.domain.everyday import Speaker, with_everyday
from nsrm_harness.domain.program import AND, Program, Relation, Step
from nsrm_harness.evaluation.compounds import put_beside
from nsrm_harness.evaluation.language import count, understand

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))
STEP = Step("MoveBetween", ("red",), ("blue",), reference_relations=(Relation(AND, ("green",)),))
SETTINGS = replace(
    SPLITS["test"], count=4, seed=8, steps=(1, 1), final_image=False, renderer="pybullet"
)


@pytest.fixture(scope="module")
def judge(tmp_path_factory: pytest.TempPathFactory) -> Iterator[GroundTruth]:
    path: Path = tmp_path_factory.mktemp("between") / "test.h5"
    assert generate(SETTINGS, domains.load(domains.FOUR_SIDES), path)
    with GroundTruth(path) as truth:
        yield truth


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"between": ["MoveRight", "MoveLeft"]}, "MoveBetween.between: expected 1, got 2"),
        ({"between": ["MoveUp"]}, "MoveBetween: no action 'MoveUp'"),
        ({"any": ["MoveRight"]}, "MoveBetween: expected one of any, all and between"),
    ],
)
def test_what_is_between_nothing_is_refused(change: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["compounds"]["made"][-1] |= change
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


def test_a_speaker_names_both() -> None:
    speaker = Speaker(DOMAIN, np.random.default_rng(1))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [
        (" ".join(speaker.sentence((STEP,))), (STEP,)) for _ in range(100)
    ]
    assert all(" and " in sentence for sentence, _ in told)
    outcome = count("between", understand(model, told))
    assert outcome.wrong == 0 and outcome.right > 90, outcome


def test_the_built_in_model_understands_them_and_obeys_no_near_miss() -> None:
    sentences = BetweenSentences(DOMAIN, np.random.default_rng(5))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(400)]
    outcome = count("between", understand(model, told))
    assert outcome.wrong == 0 and outcome.right > 385, outcome
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(400)]
    assert count("not between", understand(model, misses)).wrong == 0


def test_in_scenes_the_goal_is_halfway_between_two_that_stand_on_the_table(
    judge: GroundTruth,
) -> None:
    found = 0
    for index in range(len(judge)):
        truth = judge.truth(index)
        for put in between_programs(DOMAIN, truth):
            found += 1
            (goal,) = put.goals
            (relation,) = put.step.reference_relations
            (other,) = (
                number
                for number, values in enumerate(truth.attributes)
                if {*relation.to} <= {*values.values()}
            )
            ends = [truth.initial_poses[each].position for each in (put.reference, other)]
            assert goal[:2] == pytest.approx(np.mean(ends, axis=0)[:2])
    assert found > 0
    assert put_beside(DOMAIN, judge, 0)["between in scenes"]


def test_a_domain_in_which_nothing_is_between_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="nothing is put between"):
        BetweenSentences(replace(DOMAIN, compounds=None), np.random.default_rng(0))
