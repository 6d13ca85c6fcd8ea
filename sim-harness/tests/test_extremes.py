"""Extremes in descriptions, "the leftmost red block": said, read, and true of a scene's blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_step_episodes import truths_of

from nsrm_harness import domain as domains
from nsrm_harness.data.extremes import FARTHER_M, LARGER, SAME_M, ExtremeDescriptions
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.relations import Described
from nsrm_harness.data.tell import extreme_programs, misleading_extremes
from nsrm_harness.domain.everyday import Speaker, with_everyday
from nsrm_harness.domain.program import Relation, Step, canonical
from nsrm_harness.domain.recogniser import Recogniser
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.simulation.blocks import block_from_attributes

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))
#: The world's direction of each extreme.
DIRECTIONS = {
    "topmost": (0, 0, 1),
    "rightmost": (0, 1, 0),
    "leftmost": (0, -1, 0),
    "frontmost": (1, 0, 0),
    "rearmost": (-1, 0, 0),
}


@pytest.fixture(scope="module")
def truths(tmp_path_factory: pytest.TempPathFactory) -> list[Truth]:
    path = tmp_path_factory.mktemp("extremes") / "validation.h5"
    return truths_of(path, count=12, seed=9)


def test_a_step_with_extremes_is_the_same_after_json() -> None:
    relation = Relation("MoveLeft", ("white",), "topmost")
    step = Step("MoveOn", (), ("blue", "small"), (relation,), (), "leftmost", "rightmost")
    assert step.as_json() == {
        "action": "MoveOn",
        "object": {
            "concepts": [],
            "which": "leftmost",
            "relation": {"name": "MoveLeft", "to": {"concepts": ["white"], "which": "topmost"}},
        },
        "reference": {"concepts": ["blue", "small"], "which": "rightmost"},
    }
    assert Step.from_json(step.as_json()) == step
    assert canonical([step]) == canonical([replace(step, reference=("small", "blue"))])
    assert canonical([step]) != canonical([replace(step, object_which=None)])
    other = replace(relation, which="leftmost")
    assert canonical([step]) != canonical([replace(step, object_relations=(other,))])


def test_extremes_are_said_and_recognised_as_values() -> None:
    rng = np.random.default_rng(5)
    speaker, tokenizer, recogniser = Speaker(DOMAIN, rng), Tokenizer(DOMAIN), Recogniser.of(DOMAIN)
    relation = Relation("MoveLeft", ("white",), "topmost")
    steps = {
        Step("MoveOn", ("red",), ("blue",), object_which="leftmost"): [1, 1],
        Step("MoveOn", (), (), object_which="frontmost", reference_which="rearmost"): [0, 0],
        Step("MoveOn", (), ("blue",), (relation,), object_which="leftmost"): [0, 1, 1],
    }
    for step, concepts in steps.items():
        for _ in range(100):
            words = speaker.sentence((step,))
            tokens = tokenizer(" ".join(words))
            assert sorted(map(len, tokens.groups)) == concepts, " ".join(words)
            assert recogniser.step(tokens.words), " ".join(words)


#: Greater is meant by the largest.
SIGNS = {"largest": 1.0, "smallest": -1.0}


def measures(truth: Truth, described: Described) -> dict[int, float]:
    """How far each of the blocks that fit lies in the direction of the extreme, metres; or the
    logarithm of its volume, with a sign."""
    assert described.which is not None
    found: dict[int, float] = {}
    for index, values in enumerate(truth.attributes):
        if not set(described.concepts) <= set(values.values()):
            continue
        if described.which in DIRECTIONS:
            position = truth.initial_poses[index].position
            found[index] = float(np.dot(position, DIRECTIONS[described.which]))
        else:
            edges_m = block_from_attributes(DOMAIN, values).edges_m
            found[index] = SIGNS[described.which] * float(np.log(np.prod(edges_m)))
    return found


def test_an_extreme_is_clearly_the_farthest_of_several(truths: list[Truth]) -> None:
    names = set[str]()
    for truth in truths:
        extremes = ExtremeDescriptions(DOMAIN, truth)
        for block in range(len(truth.attributes)):
            for described in extremes.of(block):
                measure = measures(truth, described)
                own = measure.pop(block)
                assert described.which is not None
                least = FARTHER_M if described.which in DIRECTIONS else np.log(LARGER)
                assert measure and own - max(measure.values()) >= least - 1e-9
                names.add(described.which)
    assert names == {*DIRECTIONS, *SIGNS}


def test_an_extreme_that_misleads_is_of_none_or_not_clear(truths: list[Truth]) -> None:
    unclear = absent = 0
    for truth in truths:
        extremes = ExtremeDescriptions(DOMAIN, truth)
        for described in extremes.unclear():
            *_, second, first = sorted(measures(truth, described).values())
            assert first - second <= (SAME_M if described.which in DIRECTIONS else 0.0) + 1e-9
            unclear += 1
        for described in extremes.absent():
            assert not measures(truth, described)
            known = {value for values in truth.attributes for value in values.values()}
            assert {*described.concepts} <= known
            absent += 1
    assert absent > 50 and unclear > 50


def test_programs_with_extremes_are_of_single_steps(truths: list[Truth]) -> None:
    rng = np.random.default_rng(1)
    for make in (extreme_programs, misleading_extremes):
        every = [make(DOMAIN, truth, rng, 4) for truth in truths]
        assert sum(map(len, every)) > len(truths)
        for truth, programs in zip(truths, every, strict=True):
            for (step,) in programs:
                assert step.action == truth.steps[0].step.action
                assert step.object_which is not None or step.reference_which is not None
        twice = replace(truths[0], steps=truths[0].steps * 2)
        assert not make(DOMAIN, twice, rng, 4)
