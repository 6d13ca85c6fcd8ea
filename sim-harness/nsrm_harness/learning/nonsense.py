"""Makes meaningless steps: good ones with words shuffled, omitted or replaced.

Final scenes show what sentences mean, but never that one means nothing. A parser that was trained
only on meaningful steps is just as sure about word salad. So the trainer makes such steps from
those that it has and asks for a uniform distribution over actions, which the planner refuses.

A step that has a meaning after all would teach doubt about good sentences: "on top of" without its
last words is "on", a replaced word may be a synonym, and two shuffled words often keep their order.
So the words left before a description are never words that some sentence has there, at least two
words and more than half are replaced, and short steps are not shuffled.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.domain.patterns import HASH_BASE, RESERVED_SHIFT
from nsrm_harness.learning.dataset import Sentences, doubled
from nsrm_harness.learning.model import GROUP_TOKEN

LEAST_SHUFFLED = 7
"""Smallest number of tokens of a shuffled step."""
LEAST_EXCHANGED = 2
LEAST_KNOWN = 256
"""Smallest size of a table of hashes: larger than needed, so that different data share compiled
code."""


def nonsense(
    key: Array, tokens: Array, valid: Array, known: Array, words: int
) -> tuple[Array, Array]:
    """Makes a step meaningless, keeping its descriptions: tokens `[T]`, valid `[T]`.

    With equal probability it shuffles all tokens, omits words before a description, replaces more
    than half of those, or replaces more than half of all words.

    * `known`: the words before descriptions in sentences; see `known_gaps`
    * `words`: number of rows of the embedding
    """
    kind, draw, other, place, first, second, some = jax.random.split(key, 7)
    is_group = valid & (tokens == GROUP_TOKEN)
    is_word = valid & ~is_group
    draws = jax.random.uniform(draw, tokens.shape)
    foreign = jax.random.randint(other, tokens.shape, 1, words)
    gap_of = jnp.cumsum(is_group)
    gap = is_word & (gap_of == jax.random.randint(place, (), 0, gap_of[-1]))
    part = _most(some, gap)
    left_out = jnp.where(jnp.isin(gap_hash(tokens, gap & ~part), known), gap, part)
    chosen = jax.random.randint(kind, (), 0, 4)
    chosen = jnp.where((chosen == 0) & (valid.sum() < LEAST_SHUFFLED), 2, chosen)
    chosen = jnp.where((chosen == 2) & (gap.sum() < LEAST_EXCHANGED), 1, chosen)
    result = jnp.stack(
        [
            tokens[jnp.argsort(jnp.where(valid, draws, 2.0))],
            tokens[jnp.argsort(~(valid & ~left_out), stable=True)],
            jnp.where(_most(first, gap), foreign, tokens),
            jnp.where(_most(second, is_word), foreign, tokens),
        ]
    )[chosen]
    left = jnp.arange(tokens.shape[0]) < valid.sum() - jnp.where(chosen == 1, left_out.sum(), 0)
    return jnp.where(left, result, 0), left


def gap_hash(tokens: Array, among: Array) -> Array:
    """Hash of the chosen words in their order, uint32; 0 for none. Collisions have a probability of
    one in four billion."""
    order = jnp.cumsum(among) - 1
    powers = jnp.cumprod(jnp.full(tokens.shape, HASH_BASE, jnp.uint32))
    return jnp.sum(jnp.where(among, tokens.astype(jnp.uint32) * powers[order], 0), dtype=jnp.uint32)


def is_reserved(tokens: Array, valid: Array) -> Array:
    """Whether a step is kept from training: bool; see `domain.patterns`."""
    return gap_hash(tokens + 1, valid) >> RESERVED_SHIFT == 0


def known_gaps(sentences: Sentences) -> Array:
    """Hashes of the words before descriptions: every `gap_hash`, sorted, uint32 `[K]`; the last one
    is repeated until K is `doubled`."""
    count = sentences.groups.shape[1]
    valid = jnp.arange(sentences.tokens.shape[1]) < sentences.length[:, None]

    def one(tokens: Array, valid: Array, groups: Array) -> Array:
        is_group = valid & (tokens == GROUP_TOKEN)
        gap_of = jnp.where(valid & ~is_group, jnp.cumsum(is_group), -1)
        hashes = jax.vmap(lambda gap: gap_hash(tokens, gap_of == gap))(jnp.arange(count))
        return jnp.where(jnp.arange(count) < groups, hashes, 0)

    found = jax.vmap(one)(jnp.asarray(sentences.tokens), valid, jnp.asarray(sentences.group_count))
    return unique_hashes(found)


def unique_hashes(found: Array) -> Array:
    """The unique hashes, sorted; the last one is repeated until their number is `doubled` and at
    least `LEAST_KNOWN`."""
    known = np.unique(found)
    room = max(doubled(len(known)), LEAST_KNOWN) - len(known)
    return jnp.asarray(np.pad(known, (0, room), mode="edge"))


def _most(key: Array, among: Array) -> Array:
    """A random selection of more than half of them: bool `[T]`."""
    size, order = jax.random.split(key)
    count = among.sum()
    size = jax.random.randint(size, (), count // 2 + 1, jnp.maximum(count, 1) + 1)
    draws = jnp.where(among, jax.random.uniform(order, among.shape), 2.0)
    return among & (jnp.argsort(jnp.argsort(draws)) < size)
