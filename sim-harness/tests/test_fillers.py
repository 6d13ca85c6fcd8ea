"""Fillers: words that change nothing, and steps with some of them inserted."""

from __future__ import annotations

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from learn_steps import DOMAIN, ORDER_WORDS, WORDS, step_table, words_of

from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.fillers import (
    MOST,
    Fillers,
    fillers,
    omitted_without_change,
    with_fillers,
)
from nsrm_harness.learning.model import GROUP_TOKEN


@pytest.fixture(scope="module")
def table() -> StepTable:
    return step_table()


@pytest.fixture(scope="module")
def found(table: StepTable) -> Fillers:
    return fillers(table, ORDER_WORDS)


def named(chosen: jax.Array) -> set[str]:
    return {WORDS[row] for row in np.flatnonzero(chosen)}


def test_words_that_can_be_left_out_change_nothing(table: StepTable) -> None:
    found = named(jnp.asarray(omitted_without_change(table, len(WORDS))))
    assert found >= {"please", "now", "first", ",", "block", "cube", "a"}
    # With and without it the same is said, but only of right and left.
    assert "side" not in found
    assert not found & {"on", "to", "of", "the", "right", "left", "put", "over"}


def test_fillers_stand_between_parts_and_nouns_behind_values(found: Fillers) -> None:
    # A noun says what is described, an article that something is, an order word may say which.
    assert named(found.free) == {"please", "now", ","}
    assert named(found.nouns) == set(DOMAIN.grammar.nouns)
    relations = {phrase.split()[0] for action in DOMAIN.actions for phrase in action.phrases}
    assert named(found.starts) == relations | set(DOMAIN.grammar.verbs)


@pytest.mark.slow
def test_a_step_with_fillers_means_the_same(table: StepTable, found: Fillers) -> None:
    keys = jax.random.split(jax.random.key(1), len(table.length))
    filled = jax.jit(jax.vmap(with_fillers, (0, 0, None)))(keys, table, found)
    added = np.asarray(filled.length - table.length)
    assert set(added) == set(range(MOST + 1))
    assert 0.4 < np.mean(added == 0) < 0.6
    table, filled = jax.tree.map(np.asarray, (table, filled))
    parts = {"X", *DOMAIN.grammar.nouns, *named(found.free), "first"}
    for row, more in enumerate(added):
        before = table.tokens[row][: table.length[row]].tolist()
        after = filled.tokens[row][: filled.length[row]].tolist()
        for old, new in zip(table.meant[1:], filled.meant[1:], strict=True):
            assert after[int(new[row])] == GROUP_TOKEN
            groups = [
                np.cumsum(np.array(said) == GROUP_TOKEN)[int(at[row])]
                for said, at in ((before, old), (after, new))
            ]
            assert groups[0] == groups[1]
        # What was said is still said in its order; the rest are fillers.
        rest = iter(after)
        assert all(token in rest for token in before)
        assert sorted(after) == sorted(before) or more > 0
        extra = np.bincount(after, minlength=99) - np.bincount(before, minlength=99)
        assert extra.sum() == more and set(np.flatnonzero(extra)) <= set(np.flatnonzero(found.free))
        # None of them stands inside a part: "on please the right of", "the please red block".
        words = words_of(filled.tokens[row], filled.length[row]).split()
        for previous, word in pairwise(words):
            assert word not in named(found.free) or previous in parts, words


def test_without_fillers_a_step_stays_as_it_is(table: StepTable) -> None:
    step = jax.tree.map(lambda column: column[0], table)
    none = Fillers(*[jnp.zeros(len(WORDS), bool)] * 3)
    for key in jax.random.split(jax.random.key(2), 8):
        filled = with_fillers(key, step, none)
        assert int(filled.length) == int(step.length)
        assert filled.tokens.shape == (step.tokens.shape[0] + MOST,)
        length = int(step.length)
        np.testing.assert_array_equal(filled.tokens[:length], step.tokens[:length])
