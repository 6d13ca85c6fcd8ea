"""Sentences that say nothing: the words of a command shuffled, left out or exchanged.

Final scenes show what sentences mean, never that one means nothing. A parser that has heard
sense alone is as sure about a heap of words. So the trainer makes such heaps from the
sentences that it has and asks for an even distribution over actions, which the planner
refuses. A heap that happens to be a sentence is outvoted by the demonstrations that have it.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.learn.model import GROUP_TOKEN
from nsrm_harness.learn.splits import Command

LEAST_SHARE = 0.4
"""Of the words between descriptions, at least this share is left out or exchanged."""


def nonsense(key: Array, command: Command, words: int) -> Command:
    """A command without a meaning, with the same descriptions; `words`: rows of the embedding.

    With equal chances all of its tokens are shuffled, some words left out, or some exchanged.
    """
    kind, share, pick, other = jax.random.split(key, 4)
    tokens, length = command.tokens, command.length
    position = jnp.arange(tokens.shape[0])
    valid = position < length
    is_word = valid & (tokens != GROUP_TOKEN)
    share = jax.random.uniform(share, minval=LEAST_SHARE)
    draw = jax.random.uniform(pick, tokens.shape)
    hit = is_word & (draw < share)
    shuffled = tokens[jnp.argsort(jnp.where(valid, draw, 2.0))]
    thinned = tokens[jnp.argsort(jnp.where(valid & ~hit, position, position + 2 * len(position)))]
    exchanged = jnp.where(hit, jax.random.randint(other, tokens.shape, 1, words), tokens)
    chosen = jax.random.randint(kind, (), 0, 3)
    result = jnp.stack([shuffled, thinned, exchanged])[chosen]
    left = jnp.where(chosen == 1, length - hit.sum(), length)
    return command._replace(tokens=jnp.where(position < left, result, 0), length=left)
