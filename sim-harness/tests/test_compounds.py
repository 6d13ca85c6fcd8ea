"""Compounds of actions: what is said of them, and what is judged to be put there."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.compounds import CompoundSentences, compound_programs
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.domain.compounds import compounds_of
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.recogniser import means_compound
from nsrm_harness.evaluation.compounds import PutBeside
from nsrm_harness.geometry.pose import Pose

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_a_domain_has_the_compounds_that_its_actions_make() -> None:
    table: dict[str, Any] = {
        "rules": {"near": ["by", "next to"]},
        "sides": ["right", "left"],
        "made": [
            {"name": "Any", "any": ["MoveRight", "MoveFront"], "said": ["{near}", "right {near}"]},
            {"name": "All", "all": ["MoveRight", "MoveFront"], "said": ["aslant"]},
        ],
    }
    assert compounds_of(table, ["MoveRight", "MoveFront"], "") == {
        "made": [
            {**table["made"][0], "said": ["by", "next to", "right by", "right next to"]},
            table["made"][1],
        ],
        "sides": ["left", "right"],
    }
    without = compounds_of(table, ["MoveRight"], "")
    assert without is not None
    assert [(each["name"], each["any"]) for each in without["made"]] == [("Any", ["MoveRight"])]
    # What it is read as.
    assert compounds_of(table, ["MoveFront"], "") is None
    narrow = with_everyday(domains.load(domains.DEFAULT)).compounds
    assert narrow is not None
    made = [(each.name, each.parts) for each in narrow.made]
    assert made == [("MoveNextTo", ("MoveRight", "MoveLeft")), ("MoveBetween", ("MoveRight",))]


def test_a_sentence_means_a_compound_if_it_names_no_side_besides() -> None:
    assert means_compound(DOMAIN, "put the red block right next to the blue one")
    assert means_compound(DOMAIN, "To the left and in front of the blue, put the one on the right.")
    assert not means_compound(DOMAIN, "put the red block next to the blue one , on its left")
    assert not means_compound(DOMAIN, "put the red block on the blue one")
    assert not means_compound(replace(DOMAIN, compounds=None), "put red next to blue")


def test_sentences_say_all_that_can_be_done() -> None:
    assert DOMAIN.compounds is not None
    sentences = CompoundSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    firsts = [program[0] for _, program in told]
    # What is put between two objects has sentences of its own.
    made = [compound for compound in DOMAIN.compounds.made if not compound.between]
    names = {compound.name for compound in made}
    for fits in (
        lambda step: step.action == "MoveNextTo",
        lambda step: step.action == "MoveBehindLeft",
        lambda step: [each.name in names for each in step.object_relations] == [True],
        lambda step: [each.name in names for each in step.reference_relations] == [True],
    ):
        assert sum(bool(fits(step)) for step in firsts) > 100
    assert sum(len(program) == 2 for _, program in told) > 300
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    for compound in made:
        for each in compound.said:
            assert f" {each} " in text, each
    assert "  " not in text and "{" not in text


def test_near_misses_put_nothing_there() -> None:
    sentences = CompoundSentences(DOMAIN, np.random.default_rng(4))
    text = f" {' | '.join(sentences.near_miss() for _ in range(1000))} "
    for each in ("or", "do not", "upside down", "cut", "itself", "please first", "away from"):
        assert f" {each} " in text, each


def test_a_domain_without_compounds_has_no_such_sentences() -> None:
    plain = replace(DOMAIN, compounds=None)
    with pytest.raises(ValueError, match="no compounds"):
        CompoundSentences(plain, np.random.default_rng(0))
    assert list(compound_programs(plain, _truth())) == []


def _truth() -> Truth:
    """A small red block on a lego blue one, and a small green one in front of them."""
    values = (("red", "small"), ("blue", "lego"), ("green", "small"))
    places = ((0.5, 0.0, 0.07), (0.5, 0.0, 0.025), (0.58, 0.0, 0.02))
    truth = SimpleNamespace(
        attributes=[{"color": color, "size": size} for color, size in values],
        initial_poses=tuple(Pose(place, (0.0, 0.0, 0.0, 1.0)) for place in places),
        edges_m=np.array([[0.04, 0.04, 0.04], [0.06, 0.06, 0.05], [0.04, 0.04, 0.04]]),
    )
    return cast(Truth, truth)


def test_what_carries_none_is_put_where_there_is_room() -> None:
    puts = list(compound_programs(DOMAIN, _truth()))
    # The blue one carries the red one, which stands on no table.
    assert {(put.moved, put.reference) for put in puts} == {(0, 1), (0, 2), (2, 1)}
    (beside,) = (
        put
        for put in puts
        if (put.step.action, put.moved) == ("MoveNextTo", 0) and put.reference == 1
    )
    # Right, left and in front, where the green one stands.
    assert beside.is_any and len(beside.goals) == 3
    assert {round(abs(y), 3) for _, y, _ in beside.goals} == {0.075, 0.0}
    (aslant,) = (
        put
        for put in puts
        if put.step.action == "MoveFrontLeft" and put.reference == 1 and put.moved == 2
    )
    ((x, y, z),) = aslant.goals
    assert not aslant.is_any
    assert x == pytest.approx(0.5 + 0.075) and abs(y) == pytest.approx(0.075)
    assert z == pytest.approx(0.02)


def test_a_plan_is_judged_by_its_block_and_its_place() -> None:
    puts = compound_programs(DOMAIN, _truth())
    put = next(put for put in puts if put.step.action == "MoveNextTo")
    truth = _truth()
    places = np.array([pose.position for pose in truth.initial_poses])
    said = PutBeside(0, put, places, truth.edges_m)
    assert said.program == (put.step,)

    def is_done(object_id: int, reference_id: int, off_m: float, goal: int = 0) -> bool:
        x, y, z = put.goals[goal]
        step = SimpleNamespace(
            object_id=object_id, reference_id=reference_id, position=(x + off_m, y, z)
        )
        return said.is_done_by(cast(Any, SimpleNamespace(steps=[step])))

    assert is_done(put.moved + 1, put.reference + 1, 0.01)
    assert not is_done(put.moved + 1, put.reference + 1, 0.04)
    # The green one stands there.
    assert not is_done(put.moved + 1, put.reference + 1, 0.01, goal=2)
    assert not is_done(put.moved + 2, put.reference + 1, 0.0)
    assert not is_done(put.moved + 1, put.reference + 2, 0.0)
