"""Finds fillers, words between the parts of a step that change nothing: "please", "now", a comma.

Demonstrations show which words they are: the step without such a word also occurs, with the same
outcome; and the word is equally frequent with every action. In training they are inserted where no
sentence has them, so that the parser does not take a new word order for nonsense. They are inserted
only between the parts: "the block left of" and "the first red block" mean more than "the left of"
and "the red block".
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.model import GROUP_TOKEN, MISSING, Parse

LEAST_OMITTED = 0.7
"""Smallest share of a filler's occurrences without which the rest also occurs. In 2,500
demonstrations the lowest filler is "and" with 0.78; "the" has 0.54, because of "on the right
of"."""
LEAST_SHARE = 0.5
"""Smallest frequency of a filler with any action, relative to its overall frequency. "Side" can be
omitted everywhere, but occurs with two actions only."""
LEAST_SEEN = 20
"""Smallest number of occurrences of a filler: with fewer, a word with a meaning may have such a
share by chance."""
MOST = 3
"""Largest number of fillers inserted into a step."""


class Fillers(NamedTuple):
    """The fillers found in demonstrations; each field is bool `[V]`, per row of the embedding."""

    free: Array
    """Words that may stand between any two parts."""
    nouns: Array
    """Words that stand only directly after attribute values."""
    starts: Array
    """Words that occur directly after a free filler: a part may begin with them."""


def fillers(table: StepTable, order_words: np.ndarray) -> Fillers:
    """Finds the fillers of the steps.

    `order_words`, bool `[V]`: words that look like fillers at the start of a sentence, their only
    place in demonstrations, and have a meaning elsewhere.
    """
    changes_nothing = omitted_without_change(table, len(order_words))
    behind = np.zeros_like(changes_nothing)
    before, elsewhere = behind.copy(), behind.copy()
    pairs = set()
    for tokens, length in zip(np.asarray(table.tokens), np.asarray(table.length), strict=True):
        step = tokens[:length]
        elsewhere[step[0]] = True
        elsewhere[step[1:][step[:-1] != GROUP_TOKEN]] = True
        behind[step[1:][step[:-1] == GROUP_TOKEN]] = True
        before[step[:-1][step[1:] == GROUP_TOKEN]] = True
        pairs |= set(zip(step[:-1].tolist(), step[1:].tolist(), strict=True))
    nouns = changes_nothing & behind & ~elsewhere
    free = changes_nothing & ~nouns & ~before & ~order_words
    starts = np.zeros_like(free)
    for word, next_word in pairs:
        starts[next_word] |= free[word] & (next_word != GROUP_TOKEN)
    return Fillers(jnp.asarray(free), jnp.asarray(nouns), jnp.asarray(starts))


def omitted_without_change(table: StepTable, words: int) -> np.ndarray:
    """Which words can be omitted from the steps that have them: bool `[V]`.

    `words`: V.
    """
    steps = [
        tokens[:length]
        for tokens, length in zip(np.asarray(table.tokens), np.asarray(table.length), strict=True)
    ]
    actions = np.asarray(table.meant.action)
    # The words before each description, in steps with the same action and order.
    kinds = list(zip(actions.tolist(), _order(table), strict=True))
    gaps = {
        (kind, place, gap)
        for kind, step in zip(kinds, steps, strict=True)
        for place, gap in enumerate(_gaps(step))
    }
    found = np.zeros(words, bool)
    for word in np.unique(np.concatenate([*steps, [GROUP_TOKEN]])):
        if word == GROUP_TOKEN:
            continue
        omitted = [
            (kind, place, gap[:at] + gap[at + 1 :]) in gaps
            for kind, step in zip(kinds, steps, strict=True)
            for place, gap in enumerate(_gaps(step))
            for at, other in enumerate(gap)
            if other == word
        ]
        said = np.array([word in step for step in steps])
        shares = [said[actions == action].mean() for action in np.unique(actions)]
        if (
            len(omitted) >= LEAST_SEEN
            and np.mean(omitted) >= LEAST_OMITTED
            and min(shares) >= LEAST_SHARE * said.mean()
        ):
            found[word] = True
    return found


def with_fillers(key: Array, step: StepTable, fillers: Fillers) -> StepTable:
    """Inserts up to `MOST` free fillers between the parts of a step `[T]`, in half of the cases
    none; the result `[T + MOST]` has the same meaning."""
    half, number, which, where = jax.random.split(key, 4)
    position = jnp.arange(step.tokens.shape[0])
    is_inside = position < step.length
    # A part ends with attribute values, a noun or a filler, and begins like one after a filler.
    ends = (step.tokens == GROUP_TOKEN) | (fillers.free | fillers.nouns)[step.tokens]
    ends = jnp.concatenate([jnp.ones(1, bool), ends[:-1]])
    between = is_inside & ends & fillers.starts[step.tokens]
    some = jax.random.bernoulli(half) & fillers.free.any() & between.any()
    count = jnp.where(some, jax.random.randint(number, (), 1, MOST + 1), 0)
    chosen = jax.random.categorical(which, jnp.where(fillers.free, 0.0, MISSING), shape=(MOST,))
    before = jax.random.categorical(where, jnp.where(between, 0.0, MISSING), shape=(MOST,))
    added = jnp.arange(MOST) < count
    places = jnp.concatenate([jnp.where(added, before - 0.5, jnp.inf), position])
    tokens = jnp.concatenate([chosen, step.tokens])[jnp.argsort(places)]

    def moved(index: Array) -> Array:
        return index + jnp.sum(added & (before <= index))

    meant = Parse(step.meant.action, moved(step.meant.object), moved(step.meant.reference))
    return StepTable(tokens, step.length + count, step.follows, meant)


def _order(table: StepTable) -> list[bool]:
    """Whether the moved object is named first."""
    return (np.asarray(table.meant.object) < np.asarray(table.meant.reference)).tolist()


def _gaps(step: np.ndarray) -> list[tuple[int, ...]]:
    """The words before each description of a step, and after the last."""
    ends = [*np.flatnonzero(step == GROUP_TOKEN), len(step)]
    starts = [0, *(end + 1 for end in ends[:-1])]
    return [tuple(step[start:end].tolist()) for start, end in zip(starts, ends, strict=True)]
