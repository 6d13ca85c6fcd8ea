"""Steps that say nothing: the words of a good one shuffled, left out or exchanged.

Final scenes show what sentences mean, never that one means nothing. A parser that has heard
sense alone is as sure about a heap of words. So the trainer makes such heaps from the steps
that it has and asks for an even distribution over actions, which the planner refuses.

A heap that means something after all teaches doubt about good sentences: "on top of" without
its last words is "on", a word for another may be its synonym, and two words shuffled are often
as they were. So what is left before a description is never what some sentence has there, at
least two words are exchanged, more than half, and short steps are not shuffled.
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
"""Tokens of a step that is shuffled, at least."""
LEAST_EXCHANGED = 2
LEAST_KNOWN = 256
"""Places for hashes: more than there are last two words before descriptions, so that what is
compiled for some data serves others."""


def nonsense(
    key: Array, tokens: Array, valid: Array, known: Array, words: int
) -> tuple[Array, Array]:
    """A step without a meaning, with the same descriptions: tokens `[T]`, valid `[T]`.

    With equal chances all tokens are shuffled, words before a description left out, more than half
    of those exchanged, or more than half of all words.

    * `known`: what stands before descriptions in sentences; see `known_gaps`
    * `words`: rows of the embedding
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
    """A number for the chosen words in their order, uint32; 0 for none. Equal by chance once in
    four thousand millions."""
    order = jnp.cumsum(among) - 1
    powers = jnp.cumprod(jnp.full(tokens.shape, HASH_BASE, jnp.uint32))
    return jnp.sum(jnp.where(among, tokens.astype(jnp.uint32) * powers[order], 0), dtype=jnp.uint32)


def is_reserved(tokens: Array, valid: Array) -> Array:
    """Whether a step is kept from training: bool; see `language.patterns`."""
    return gap_hash(tokens + 1, valid) >> RESERVED_SHIFT == 0


def known_gaps(sentences: Sentences) -> Array:
    """What stands before descriptions in them: every `gap_hash`, sorted, uint32 `[K]`; the last is
    repeated until K is `doubled`."""
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
    """Each of them once, sorted; the last is repeated until their number is `doubled`, and at
    least `LEAST_KNOWN`."""
    known = np.unique(found)
    room = max(doubled(len(known)), LEAST_KNOWN) - len(known)
    return jnp.asarray(np.pad(known, (0, room), mode="edge"))


def _most(key: Array, among: Array) -> Array:
    """More than half of them, at random: bool `[T]`."""
    size, order = jax.random.split(key)
    count = among.sum()
    size = jax.random.randint(size, (), count // 2 + 1, jnp.maximum(count, 1) + 1)
    draws = jnp.where(among, jax.random.uniform(order, among.shape), 2.0)
    return among & (jnp.argsort(jnp.argsort(draws)) < size)
