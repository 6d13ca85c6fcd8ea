"""Splits commands into steps, and computes the probability of each split."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.learning.model import GROUP_TOKEN, MISSING, Splitter


class TokenizedCommand(NamedTuple):
    """A sentence as arrays; see `dataset.Sentences` for shapes without the leading axis."""

    tokens: Array
    length: Array
    groups: Array
    group_count: Array


def step_tokens(
    command: TokenizedCommand, first: Array, end: Array, width: int | None = None
) -> tuple[Array, Array, Array]:
    """Moves the tokens `first..end` to the front: tokens `[W]`, valid `[W]`, groups `[G, K]`.

    `width`: W, the largest number of tokens of a step; by default T.
    """
    total = command.tokens.shape[0]
    position = jnp.arange(width or total)
    valid = position < end - first
    source = jnp.clip(position + first, 0, total - 1)
    tokens = jnp.where(valid, command.tokens[source], 0)
    skipped = jnp.sum((command.tokens == GROUP_TOKEN) & (jnp.arange(total) < first))
    order = jnp.arange(command.groups.shape[0])
    groups = command.groups[jnp.clip(order + skipped, 0, order.shape[0] - 1)]
    return tokens, valid, groups


def split_log_probability(splitter: Splitter, command: TokenizedCommand, first: Array) -> Array:
    """Log probability that the step beginning at `first` ends after each token `[T]`.

    Tokens count from the command's first one; -1e9 outside. See `end_log_probability`.
    """
    position = jnp.arange(command.tokens.shape[0])
    tokens, _, _ = step_tokens(command, first, command.length)
    by_offset = end_log_probability(splitter, tokens, command.length - first)
    source = position - first
    return jnp.where(source >= 0, by_offset[jnp.clip(source, 0)], MISSING)


def end_log_probability(splitter: Splitter, tokens: Array, length: Array) -> Array:
    """Log probability that the first step of the tokens `[T]` ends after each of them `[T]`.

    `h_t Π_{s<t} (1 - h_s)`; after the last token the rest, the probability of no split; -1e9 beyond
    it.
    """
    position = jnp.arange(tokens.shape[0])
    valid = position < length
    logits = splitter(tokens, valid)
    is_inner = position < length - 1
    kept = jnp.where(is_inner, jax.nn.log_sigmoid(-logits), 0.0)
    before = jnp.cumsum(kept) - kept
    here = before + jnp.where(is_inner, jax.nn.log_sigmoid(logits), 0.0)
    return jnp.where(valid, here, MISSING)
