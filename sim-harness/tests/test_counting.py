"""Words that count more steps than demonstrations have."""

from __future__ import annotations

from pathlib import Path

import jax
import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.domain.dictionary import with_dictionary
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.reader import FOUR_SIDES
from nsrm_harness.learning.counting import later_words, with_later_words
from nsrm_harness.learning.export import read_model
from nsrm_harness.learning.model import Dimensions, Model

ROOT = Path(__file__).resolve().parents[2]
DOMAIN = with_dictionary(with_everyday(domains.load(FOUR_SIDES)))
ROWS = {word: row for row, word in enumerate(DOMAIN.vocabulary())}


def test_they_take_the_place_of_those_of_the_second_step() -> None:
    found = later_words(DOMAIN)
    expected = {"third": "second", "eighth": "second", "3": "2", "8": "2", "3)": "2)"}
    for later, known in expected.items():
        assert found[ROWS[later]] == ROWS[known], later
    assert not {ROWS[word] for word in ("first", "second", "1", "2", "then")} & found.keys()
    assert later_words(domains.load()) == {}


def test_only_their_embeddings_change() -> None:
    model = Model(Dimensions.of(DOMAIN), jax.random.key(0))
    read, rows = with_later_words(model, DOMAIN), later_words(DOMAIN)
    others = [row for row in ROWS.values() if row not in rows]
    for before, after in (
        (model.language.embedding.weight, read.language.embedding.weight),
        (model.language.splitter.embedding.weight, read.language.splitter.embedding.weight),
    ):
        for later, known in rows.items():
            np.testing.assert_array_equal(after[later], before[known])
        np.testing.assert_array_equal(after[np.array(others)], before[np.array(others)])


def test_the_built_in_model_has_them() -> None:
    model = read_model(ROOT / "weights-codegen" / "tabletop" / "tabletop.safetensors").model
    weights = np.asarray(model.language.embedding.weight)
    for later, known in later_words(DOMAIN).items():
        np.testing.assert_array_equal(weights[later], weights[known])


@pytest.mark.parametrize(
    "numbers", [("first ,", "second ,", "third ,"), ("1 .", "2 .", "3 ."), ("1)", "2)", "3)")]
)
def test_three_steps_are_counted(numbers: tuple[str, str, str]) -> None:
    one, two, three = numbers
    model = nsrm.Model.pretrained()
    plan = model.parse(
        f"{one} put the red block on the blue one {two} move the green cube to the left of the "
        f"white block {three} put the yellow thing behind the small cyan block"
    )
    assert [step.action for step in plan.steps] == ["MoveOn", "MoveLeft", "MoveBehind"]
