"""Steps of the domain's own grammar, parsed, for tests of what the trainer makes from steps."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from nsrm_harness import domain as domains
from nsrm_harness.domain.grammar import Grammar, Style
from nsrm_harness.domain.program import Step
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.learning.dataset import Sentences
from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.model import GROUP_TOKEN, Parse

DOMAIN = domains.load()
WORDS = DOMAIN.vocabulary()
ORDER_WORDS = np.isin(WORDS, DOMAIN.grammar.order_words)


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


def step_table() -> StepTable:
    """As many commands as there are demonstrations."""
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


def words_of(tokens: np.ndarray, length: int) -> str:
    """A step as text; `X` stands for attribute values."""
    return " ".join("X" if row == GROUP_TOKEN else WORDS[row] for row in tokens[:length])
