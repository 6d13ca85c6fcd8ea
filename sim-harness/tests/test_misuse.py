"""Steps that no program can represent, which the trainer makes from good ones."""

from __future__ import annotations

import re
from itertools import product

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from learn_steps import DOMAIN, ORDER_WORDS, WORDS, step_table, words_of

from nsrm_harness.domain.patterns import is_reserved, pattern_hash
from nsrm_harness.learning import nonsense
from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.fillers import fillers
from nsrm_harness.learning.misuse import ROOM, habits, misuse

NOUN = f"({'|'.join(DOMAIN.grammar.nouns)})"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def table() -> StepTable:
    return step_table()


@pytest.fixture(scope="module")
def made(table: StepTable) -> list[str]:
    """What is made of each step with the next as donor, ten times; without what is left out."""
    found = habits(table, fillers(table, ORDER_WORDS), jnp.asarray(ORDER_WORDS))
    donors = jax.tree.map(lambda column: jnp.roll(column, 1, axis=0), table)
    make = jax.jit(jax.vmap(misuse, (0, 0, 0, None)))
    texts = []
    for seed in range(10):
        keys = jax.random.split(jax.random.key(seed), len(table.length))
        tokens, length = make(keys, table, donors, found)
        assert tokens.shape[1] == table.tokens.shape[1] + ROOM
        rows = zip(np.asarray(tokens), np.asarray(length), strict=True)
        texts += [words_of(row, count) for row, count in rows if count]
    assert len(texts) > 0.5 * 10 * len(table.length)
    return texts


def test_what_is_made_is_what_people_say_and_no_program_has(made: list[str]) -> None:
    for pattern in (
        rf"X ({NOUN} )?on the {NOUN} (right|left) of",
        rf"\w+ the {NOUN} (right|left) of the X( {NOUN})? on (the |a )?X",
        r"(above|atop|over|upon) (, |now |please )?(to the )?left of",
        r"to the top (right|left) of",
        r"the first X",
        r"\w+ first (on|put|the)",
        r"the (now|please|block|cube) X",
        rf"^({NOUN} )?(left|right) of (the |a )?X {NOUN} (on|above|over)",
    ):
        assert any(re.search(pattern, text) for text in made), pattern


def plain(text: str) -> str:
    """The text with one noun and one verb for all."""
    nouns, verbs = DOMAIN.grammar.nouns, DOMAIN.grammar.verbs
    return " ".join("N" if w in nouns else "V" if w in verbs else w for w in text.split())


def test_what_still_says_a_command_is_not_made(made: list[str]) -> None:
    grammar = DOMAIN.grammar
    described = {text.format(values="X", noun="N") for text in grammar.descriptions}
    beginnings = {(opening, "") for opening in grammar.openings} | {
        ("", connective) for connective in grammar.connectives
    }
    commands = set()
    phrases = [phrase for action in DOMAIN.actions for phrase in action.phrases]
    for template, (opening, connective), phrase, moved, reference in product(
        grammar.commands, beginnings, phrases, described, described
    ):
        parts = {"opening": opening, "verb": "V", "relation": phrase}
        text = template.format(moved=moved, reference=reference, **parts)
        commands.add(" ".join(f"{connective} {text}".split()))
    assert not commands & {plain(text) for text in made}


def test_nothing_is_made_of_reserved_patterns(made: list[str]) -> None:
    rows = {word: row for row, word in enumerate(WORDS)} | {"X": 0}
    assert not any(is_reserved(rows[word] for word in text.split()) for text in made)


def test_patterns_have_the_same_hash_in_both_forms() -> None:
    rng = np.random.default_rng(0)
    reserved = []
    for _ in range(200):
        rows = rng.integers(0, len(WORDS), int(rng.integers(1, 30)))
        padded = jnp.asarray(np.pad(rows, (0, 32 - len(rows))))
        valid = jnp.arange(32) < len(rows)
        assert int(nonsense.gap_hash(padded + 1, valid)) == pattern_hash(rows.tolist())
        reserved.append(is_reserved(rows.tolist()))
        assert bool(nonsense.is_reserved(padded, valid)) == reserved[-1]
    assert 0.15 < np.mean(reserved) < 0.35
