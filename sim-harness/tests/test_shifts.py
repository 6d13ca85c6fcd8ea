"""How far an object is moved from where it is: the words, sentences that say it, and where blocks
then go."""

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
from nsrm_harness.data.distances import DISTANCES_MM
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.shifts import ORIGINS, ShiftSentences, shifted_programs
from nsrm_harness.domain.distances import distances_of
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import ALL, ITSELF, Program, Step
from nsrm_harness.evaluation.compounds import PutBeside
from nsrm_harness.evaluation.language import count, understand
from nsrm_harness.geometry.pose import Pose

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def test_the_directions_of_a_wording_file_are_those_of_its_sides_with_all_their_texts() -> None:
    table: dict[str, Any] = {
        "sides": ["MoveLeft", "MoveUp"],
        "shifts": {"MoveLeft": ["{to} left", "left"], "MoveUp": ["up"]},
        "origins": ["from {where}"],
        "rules": {"to": ["to the", "towards the"], "where": ["there", "where it is"]},
    }
    read = distances_of(table, ["MoveOn", "MoveLeft"], "")
    assert read is not None
    assert read["shifts"] == {"MoveLeft": ["left", "to the left", "towards the left"]}
    assert read["origins"] == ["from there", "from where it is"]


@pytest.mark.parametrize(
    ("shifts", "problem"),
    [
        ({"MoveOn": ["up"]}, "shifts: 'MoveOn' is not in distances.sides"),
        ({"MoveLeft": ["aside"], "MoveRight": ["aside"]}, "other words for each direction"),
        ({"MoveLeft": [""]}, "remove the empty string"),
    ],
)
def test_what_is_no_direction_is_refused(shifts: Any, problem: str) -> None:
    document = json.loads(DOMAIN.as_json())
    document["distances"]["shifts"] = shifts
    with pytest.raises(DomainError, match=problem):
        domains.parse(document, "test")


def test_what_puts_something_is_a_word_of_the_grammar() -> None:
    document = json.loads(DOMAIN.as_json())
    document["placing"] = ["put", "teleport"]
    with pytest.raises(DomainError, match="placing: 'teleport' is not a word of the grammar"):
        domains.parse(document, "test")


def test_sentences_say_directions_in_all_ways() -> None:
    sentences = ShiftSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    shifts = [
        next(step for step in program if step.reference_which == ITSELF) for _, program in told
    ]
    assert {step.action for step in shifts} == {
        "MoveLeft", "MoveRight", "MoveFront", "MoveBehind",
    }  # fmt: skip
    assert all(step.distance_mm and not step.reference for step in shifts)
    assert 50 < sum(step.object_which == ALL for step in shifts) < 300
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    assert DOMAIN.distances is not None
    directions = [text for texts in DOMAIN.distances.shifts.values() for text in texts]
    assert sum(f" {each} " in text for each in directions) > 0.9 * len(directions)
    assert all(each in text for each in ORIGINS)
    assert "  " not in text and "{" not in text
    assert {len(program) for _, program in told} == {1, 2}


def test_the_built_in_model_understands_them_and_refuses_near_misses() -> None:
    sentences = ShiftSentences(DOMAIN, np.random.default_rng(5))
    model = nsrm.Model.pretrained()
    told: list[tuple[str, Program | None]] = [sentences.draw() for _ in range(300)]
    right = count("shifts", understand(model, told))
    assert right.wrong == 0 and right.right > 290, right
    misses: list[tuple[str, Program | None]] = [(sentences.near_miss(), None) for _ in range(300)]
    assert count("no shifts", understand(model, misses)).wrong <= 1


def test_a_domain_without_directions_has_no_such_sentences() -> None:
    distances = DOMAIN.distances
    assert distances is not None
    without = replace(DOMAIN, distances=replace(distances, shifts={}))
    with pytest.raises(ValueError, match="moves nothing"):
        ShiftSentences(without, np.random.default_rng(0))


def _truth() -> Truth:
    """A small red block on a lego blue one, and a small green one aside."""
    values = (("red", "small"), ("blue", "lego"), ("green", "small"))
    places = ((0.5, 0.1, 0.07), (0.5, 0.1, 0.025), (0.5, -0.1, 0.02))
    truth = SimpleNamespace(
        attributes=[{"color": color, "size": size} for color, size in values],
        initial_poses=tuple(Pose(place, UPRIGHT) for place in places),
        edges_m=np.array([[0.04, 0.04, 0.04], [0.06, 0.06, 0.05], [0.04, 0.04, 0.04]]),
    )
    return cast(Truth, truth)


def test_what_stands_on_the_table_and_carries_nothing_is_moved_as_far_as_is_said() -> None:
    puts = list(shifted_programs(DOMAIN, _truth(), np.random.default_rng(1)))
    assert {put.moved for put in puts} == {2} and len(puts) > 1
    for put in puts:
        assert put.reference == put.moved and put.step.distance_mm in DISTANCES_MM
        (goal,) = put.goals
        moved_m = np.abs(np.subtract(goal, _truth().initial_poses[2].position))
        assert moved_m[:2].max() == pytest.approx(put.step.distance_mm / 1000)
        assert moved_m[2] == 0.0


def test_a_place_a_little_off_is_not_where_it_is_moved() -> None:
    step = Step("MoveLeft", ("green",), (), reference_which=ITSELF, distance_mm=50)
    assert Step.from_json(step.as_json()) == step
    put, truth = Put(step, False, 2, 2, ((0.5, -0.15, 0.02),)), _truth()
    places = np.array([pose.position for pose in truth.initial_poses])
    said = PutBeside(0, put, places, truth.edges_m)

    def is_done(off_m: float, reference_id: int = 3) -> bool:
        planned = SimpleNamespace(
            object_id=3, reference_id=reference_id, position=(0.5, -0.15 - off_m, 0.02)
        )
        return said.is_done_by(cast(Any, SimpleNamespace(steps=[planned])))

    assert is_done(0.005) and not is_done(0.015) and not is_done(0.0, reference_id=1)
