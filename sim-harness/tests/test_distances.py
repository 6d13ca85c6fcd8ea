"""Distances from a reference: their words, sentences that say them, and where blocks then go."""

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
from nsrm_harness.data.compounds import Put
from nsrm_harness.data.distances import (
    BEHIND,
    DISTANCES_MM,
    SOURCES,
    DistanceSentences,
    spaced_programs,
)
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.moves import GAP_M
from nsrm_harness.domain.distances import distances_of
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import Program, Step, canonical
from nsrm_harness.evaluation.compounds import PutBeside
from nsrm_harness.evaluation.language import count, understand
from nsrm_harness.geometry.pose import Pose

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_texts_of_a_wording_file_are_all_those_that_its_rules_stand_for() -> None:
    table: dict[str, Any] = {
        "sides": ["MoveLeft", "MoveUp"],
        "usual_mm": 25,
        "beside": "next to",
        "before": ["{by}", "at a distance of"],
        "behind": ["away"],
        "from": ["from", "away from"],
        "unless": ["the"],
        "units": {"cm": 10},
        "numbers": {"two": 2},
        "rules": {"by": ["by", "with"]},
    }
    read = distances_of(table, ["MoveOn", "MoveLeft"], "")
    assert read is not None and "rules" not in read
    assert read["sides"] == ["MoveLeft"]
    assert read["before"] == ["at a distance of", "by", "with"]
    assert read["from"] == ["away from", "from"]
    assert distances_of(table, ["MoveOn"], "") is None
    assert distances_of({}, ["MoveLeft"], "") is None


def test_the_usual_distance_is_that_of_the_demonstrations() -> None:
    assert DOMAIN.distances is not None
    assert DOMAIN.distances.usual_mm == round(1000 * GAP_M)


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("units", {"cm": 0.0}, "units.cm"),
        ("numbers", {"two": -2}, "numbers.two"),
        ("usual_mm", 0, "usual_mm"),
        ("unless", "the", "unless"),
        ("shifts", {"MoveLeft": "left"}, "shifts"),
        ("sides", ["MoveOn"], "sides: no action 'MoveOn'; expected some of MoveRight, "),
        ("behind", ["away", ""], "remove the empty string"),
        ("beside", "beneath", "'beneath' is not a word of the grammar"),
    ],
)
def test_what_is_no_distance_is_refused(key: str, value: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["distances"][key] = value
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


def test_sentences_say_distances_in_all_ways() -> None:
    sentences = DistanceSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    firsts = [program[0] for _, program in told]
    assert all(step.distance_mm is not None and step.distance_mm > 0 for step in firsts)
    assert {step.action for step in firsts} == {
        "MoveLeft", "MoveRight", "MoveFront", "MoveBehind", "MoveNextTo",
    }  # fmt: skip
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    for each in (*BEHIND, *(f"{{}} {source}" for source in SOURCES)):
        before, behind = each.split("{}")
        assert f"{before}2 inches{behind}".strip() in text, each
    assert "  " not in text and "{" not in text
    assert sum(len(program) == 2 for _, program in told) > 300


def test_the_built_in_model_understands_them_and_refuses_near_misses() -> None:
    sentences = DistanceSentences(DOMAIN, np.random.default_rng(5))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(300)]
    right = count("distances", understand(model, told))
    assert right.wrong == 0 and right.right > 285, right
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(300)]
    assert count("no distances", understand(model, misses)).wrong == 0


def test_programs_with_other_distances_differ() -> None:
    step = Step("MoveLeft", ("red",), ("blue",))
    near, far = (replace(step, distance_mm=mm) for mm in (20, 30))
    assert len({canonical([each]) for each in (step, near, far)}) == 3
    for each in (step, near):
        assert Step.from_json(each.as_json()) == each
    assert "distance_mm" not in step.as_json()


def test_a_domain_without_distances_has_no_such_sentences() -> None:
    with pytest.raises(ValueError, match="no distances"):
        DistanceSentences(replace(DOMAIN, distances=None), np.random.default_rng(0))


def _truth() -> Truth:
    """A small red block, and a lego blue one 20 cm to its right (y)."""
    values = (("red", "small"), ("blue", "lego"))
    places = ((0.5, -0.1, 0.02), (0.5, 0.1, 0.025))
    truth = SimpleNamespace(
        attributes=[{"color": color, "size": size} for color, size in values],
        initial_poses=tuple(Pose(place, (0.0, 0.0, 0.0, 1.0)) for place in places),
        edges_m=np.array([[0.04, 0.04, 0.04], [0.06, 0.06, 0.05]]),
    )
    return cast(Truth, truth)


def test_a_block_goes_as_far_from_its_reference_as_is_said() -> None:
    puts = list(spaced_programs(DOMAIN, _truth(), np.random.default_rng(1)))
    assert {(put.moved, put.reference) for put in puts} == {(0, 1), (1, 0)}
    for put in puts:
        assert put.step.distance_mm in DISTANCES_MM
        (goal,) = put.goals
        reference = _truth().initial_poses[put.reference].position
        apart_m = np.abs(np.subtract(goal, reference))[:2].max()
        # Half of each block lies in between.
        assert apart_m == pytest.approx(0.05 + put.step.distance_mm / 1000)


def test_a_place_a_little_off_is_not_at_that_distance() -> None:
    put = Put(
        Step("MoveLeft", ("red",), ("blue",), distance_mm=50), False, 0, 1, ((0.5, 0.0, 0.02),)
    )
    truth = _truth()
    places = np.array([pose.position for pose in truth.initial_poses])
    said = PutBeside(0, put, places, truth.edges_m)

    def is_done(off_m: float) -> bool:
        step = SimpleNamespace(object_id=1, reference_id=2, position=(0.5, -off_m, 0.02))
        return said.is_done_by(cast(Any, SimpleNamespace(steps=[step])))

    assert is_done(0.005) and not is_done(0.015)
