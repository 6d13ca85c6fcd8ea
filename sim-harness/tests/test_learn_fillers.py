"""Which words change nothing, and what a step is with some of them put in."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.language.grammar import Grammar, Style
from nsrm_harness.language.program import Step
from nsrm_harness.language.tokens import Tokenizer
from nsrm_harness.learn.dataset import Sentences
from nsrm_harness.learn.decode import StepTable
from nsrm_harness.learn.fillers import MOST, fillers, with_fillers
from nsrm_harness.learn.model import GROUP_TOKEN, Parse

DOMAIN = domains.load()
WORDS = DOMAIN.vocabulary()


def table_of(sentences: Sentences, actions: list[int], moved_first: list[bool]) -> StepTable:
    """Commands of one step, understood."""
    at = np.array(
        [
            np.flatnonzero(row[:length] == GROUP_TOKEN)
            for row, length in zip(sentences.tokens, sentences.length, strict=True)
        ]
    )
    first = np.array(moved_first)
    arguments = np.where(first[:, None], at, at[:, ::-1])
    meant = Parse(*map(jnp.asarray, (np.array(actions), *arguments.T)))
    follows = jnp.zeros(len(at), bool)
    return StepTable(jnp.asarray(sentences.tokens), jnp.asarray(sentences.length), follows, meant)


@pytest.fixture(scope="module")
def table() -> StepTable:
    """As many commands of the domain's own grammar as there are demonstrations."""
    rng = np.random.default_rng(0)
    grammar, tokenizer = Grammar(DOMAIN, Style()), Tokenizer(DOMAIN)
    sentences, actions, moved_first = [], [], []
    for number in range(2500):
        action = DOMAIN.actions[number % len(DOMAIN.actions)]
        (command,) = grammar.commands(rng, (Step(action.name, ("red",), ("blue",)),))
        sentences.append(tokenizer(" ".join(command.words())))
        actions.append(number % len(DOMAIN.actions))
        moved_first.append(command.template.index("{moved}") < command.template.index("{ref"))
    return table_of(Sentences.of(tokenizer, sentences), actions, moved_first)


def test_fillers_are_the_words_that_change_nothing(table: StepTable) -> None:
    found = {WORDS[row] for row in np.flatnonzero(fillers(table, len(WORDS)))}
    assert found >= {"please", "now", "first", ",", "block", "cube", "a"}
    # With and without it the same is said, but only of right and left.
    assert "side" not in found
    assert not found & {"on", "to", "of", "the", "right", "left", "put", "over"}


def test_a_step_with_fillers_means_the_same(table: StepTable) -> None:
    words = fillers(table, len(WORDS))
    keys = jax.random.split(jax.random.key(1), len(table.length))
    filled = jax.vmap(with_fillers, (0, 0, None))(keys, table, jnp.asarray(words))
    added = np.asarray(filled.length - table.length)
    assert set(added) == set(range(MOST + 1))
    assert 0.4 < np.mean(added == 0) < 0.6
    table, filled = jax.tree.map(np.asarray, (table, filled))
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
        assert extra.sum() == more and set(np.flatnonzero(extra)) <= set(np.flatnonzero(words))


def test_without_fillers_a_step_stays_as_it_is(table: StepTable) -> None:
    step = jax.tree.map(lambda column: column[0], table)
    none = jnp.zeros(len(WORDS), bool)
    for key in jax.random.split(jax.random.key(2), 8):
        filled = with_fillers(key, step, none)
        assert int(filled.length) == int(step.length)
        assert filled.tokens.shape == (step.tokens.shape[0] + MOST,)
        length = int(step.length)
        np.testing.assert_array_equal(filled.tokens[:length], step.tokens[:length])
