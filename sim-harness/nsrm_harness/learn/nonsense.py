"""Steps that say nothing: the words of a good one shuffled, left out or exchanged.

Final scenes show what sentences mean, never that one means nothing. A parser that has heard
sense alone is as sure about a heap of words. So the trainer makes such heaps from the steps
that it has and asks for an even distribution over actions, which the planner refuses.

A heap that means something after all teaches doubt about good sentences: "on top of" without
its last words is "on", a word for another may be its synonym, and two words shuffled are often
as they were. So words are left out only all at once, the words before a description, and more
than half of them are exchanged, at least two; short steps are not shuffled.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.learn.model import GROUP_TOKEN

LEAST_SHUFFLED = 7
"""Tokens of a step that is shuffled, at least."""
LEAST_EXCHANGED = 2


def nonsense(key: Array, tokens: Array, valid: Array, words: int) -> tuple[Array, Array]:
    """A step without a meaning, with the same descriptions: tokens `[T]`, valid `[T]`.

    With equal chances all tokens are shuffled, the words before a description left out, more than
    half of those exchanged, or more than half of all words. `words`: rows of the embedding.
    """
    kind, draw, other, place, first, second = jax.random.split(key, 6)
    is_group = valid & (tokens == GROUP_TOKEN)
    is_word = valid & ~is_group
    draws = jax.random.uniform(draw, tokens.shape)
    foreign = jax.random.randint(other, tokens.shape, 1, words)
    gap_of = jnp.cumsum(is_group)
    gap = is_word & (gap_of == jax.random.randint(place, (), 0, gap_of[-1]))
    chosen = jax.random.randint(kind, (), 0, 4)
    chosen = jnp.where((chosen == 0) & (valid.sum() < LEAST_SHUFFLED), 2, chosen)
    chosen = jnp.where((chosen == 2) & (gap.sum() < LEAST_EXCHANGED), 1, chosen)
    result = jnp.stack(
        [
            tokens[jnp.argsort(jnp.where(valid, draws, 2.0))],
            tokens[jnp.argsort(~(valid & ~gap), stable=True)],
            jnp.where(_most(first, gap), foreign, tokens),
            jnp.where(_most(second, is_word), foreign, tokens),
        ]
    )[chosen]
    left = jnp.arange(tokens.shape[0]) < valid.sum() - jnp.where(chosen == 1, gap.sum(), 0)
    return jnp.where(left, result, 0), left


def _most(key: Array, among: Array) -> Array:
    """More than half of them, at random: bool `[T]`."""
    size, order = jax.random.split(key)
    count = among.sum()
    size = jax.random.randint(size, (), count // 2 + 1, jnp.maximum(count, 1) + 1)
    draws = jnp.where(among, jax.random.uniform(order, among.shape), 2.0)
    return among & (jnp.argsort(jnp.argsort(draws)) < size)
