"""What is said of the table, and what is judged to be put there."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.on_table import OTHER_PLACES, TableSentences, table_programs
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.program import ALL, TABLE, Relation
from nsrm_harness.domain.recogniser import means_rewritten
from nsrm_harness.domain.rewriting import with_sides
from nsrm_harness.evaluation.on_table import PutOnTable
from nsrm_harness.geometry.pose import Pose

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_the_table_has_the_sides_that_the_domain_has() -> None:
    table: dict[str, Any] = {"action": "MoveOn", "sides": ["MoveRight", "MoveBehind"]}
    assert with_sides(table, ["MoveOn", "MoveBehind"]) == {**table, "sides": ["MoveBehind"]}
    assert with_sides(table, ["MoveOn"]) is None
    assert with_sides(table, ["MoveBehind"]) is None
    assert with_sides({}, ["MoveOn"]) is None
    narrow = with_everyday(domains.load(domains.DEFAULT))
    assert narrow.table is not None and narrow.table.sides == ("MoveRight", "MoveLeft")


def test_sentences_say_all_that_can_be_done() -> None:
    assert DOMAIN.table is not None
    sentences = TableSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1000)]
    firsts = [program[0] for _, program in told]
    on_table = (Relation("MoveOn", (), TABLE),)
    for fits in (
        lambda step: step.reference_which == TABLE and step.object_which is None,
        lambda step: step.object_which == ALL and step.reference_which == TABLE,
        lambda step: step.object_relations == on_table,
        lambda step: step.reference_relations == on_table,
        lambda step: step.object_relations and step.reference_which is None,
        lambda step: step.object_relations and step.reference_which == TABLE,
    ):
        assert sum(bool(fits(step)) for step in firsts) > 40
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    for each in (
        *DOMAIN.table.words,
        *DOMAIN.table.off,
        *DOMAIN.table.sources,
        *DOMAIN.table.removing,
        *DOMAIN.table.down,
    ):
        assert f" {each} " in text, each
    assert "  " not in text and "{" not in text


def test_near_misses_put_nothing_on_the_table() -> None:
    sentences = TableSentences(DOMAIN, np.random.default_rng(4))
    text = f" {' | '.join(sentences.near_miss() for _ in range(2000))} "
    for each in (*OTHER_PLACES, "or", "do not", "upside down", "cut", "turn", "remove", "removed"):
        assert f" {each} " in text, each


def test_what_is_taken_from_another_object_is_no_nonsense() -> None:
    for sentence, meant in (
        ("move the red block from the blue one to the left of the white one", True),
        ("take the red toy block from the blue one and put it on the white one", True),
        ("move the red block from the blue one", False),
        ("put the red block on the one farthest from the blue one", False),
        ("put the farthest red block from the blue one behind the white one", False),
        ("from the blue one move the red block on the white one", False),
    ):
        assert means_rewritten(DOMAIN, sentence) == meant, sentence
    assert not means_rewritten(replace(DOMAIN, table=None), "move red from blue behind white")


def test_a_domain_without_a_table_has_no_such_sentences() -> None:
    plain = replace(DOMAIN, table=None)
    with pytest.raises(ValueError, match="no table"):
        TableSentences(plain, np.random.default_rng(0))
    assert not plain.table_words()


def _truth() -> Truth:
    """A small red block on a lego blue one, and a small green one beside them."""
    values = (("red", "small"), ("blue", "lego"), ("green", "small"))
    places = ((0.5, 0.0, 0.07), (0.5, 0.0, 0.025), (0.6, 0.1, 0.02))
    poses = [Pose(place, (0.0, 0.0, 0.0, 1.0)) for place in places]
    truth = SimpleNamespace(
        attributes=[{"color": color, "size": size} for color, size in values],
        initial_poses=poses,
        edges_m=np.array([[0.04, 0.04, 0.04], [0.06, 0.06, 0.05], [0.04, 0.04, 0.04]]),
    )
    return cast(Truth, truth)


def test_each_block_that_carries_none_is_put_there_unless_it_stands_there() -> None:
    found = [(block, is_lifted) for _, block, is_lifted in table_programs(DOMAIN, _truth())]
    assert found == [(1, True), (3, False)]


@pytest.mark.parametrize(
    ("position", "block", "is_right"),
    [
        ((0.4, 0.0, 0.02), 1, True),
        ((0.4, 0.0, 0.07), 1, False),
        # Into the green block, and beside it by its edge.
        ((0.57, 0.1, 0.02), 1, False),
        ((0.559, 0.1, 0.02), 1, True),
        ((0.4, 0.0, 0.02), 3, False),
    ],
)
def test_what_is_put_there_touches_nothing(
    position: tuple[float, float, float], block: int, is_right: bool
) -> None:
    truth = _truth()
    places = np.array([pose.position for pose in truth.initial_poses])
    said = PutOnTable(0, (), 1, places, truth.edges_m)
    plan: Any = SimpleNamespace(steps=[SimpleNamespace(object_id=block, position=position)])
    assert said.is_done_by(plan) is is_right
    assert not replace(said, block=None).is_done_by(plan)
