"""Makes steps of known words with a meaning that no program has, from meaningful steps.

"Put the red block on the block left of the blue block" has the words of a good sentence and one
relation too many; so have "above and to the left of" and "to the top left of". "The first red
block" is an ordinal, and "…, first put the green block there" another order of time. A parser that
was never trained on such steps drops what it cannot represent and is sure of the rest. So the
trainer makes such steps and asks for a uniform distribution over actions, which the planner
refuses.

A step that has a meaning after all would teach doubt about good sentences: "on the" inserted into
"right of the" gives "on the right of the". So the words before a description must then be words
that no sentence has there. `domain.patterns` defines which patterns are reserved for the sets that
measure this.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.fillers import Fillers
from nsrm_harness.learning.model import GROUP_TOKEN, MISSING
from nsrm_harness.learning.nonsense import gap_hash, is_reserved, unique_hashes

SHARES = (2, 2, 1, 1, 1, 1)
"""Frequencies of the kinds of `misuse`, in their order. The first two have the most variety."""
ROOM = 12
"""Largest number of tokens added to a step: the longest relation with its connective."""


class Habits(NamedTuple):
    """Properties of all steps that misuse depends on."""

    fillers: Fillers
    order_words: Array
    """Words that open a sentence and have another meaning elsewhere, bool `[V]`."""
    known: Array
    """Hashes of the words before descriptions, without fillers and the preceding description's
    noun; sorted."""
    known_ends: Array
    """Hashes of the last two words before descriptions; sorted."""
    foreign: Array
    """Words that occur with other actions and never with this one, bool `[A, V]`."""


def habits(table: StepTable, fillers: Fillers, order_words: Array) -> Habits:
    """The properties of the steps in a table."""
    groups = 1 + int(np.max(np.sum(np.asarray(table.tokens) == GROUP_TOKEN, axis=1)))

    def one(tokens: Array, length: Array) -> tuple[Array, Array]:
        valid = jnp.arange(tokens.shape[0]) < length
        is_group = valid & (tokens == GROUP_TOKEN)
        gap_of = jnp.cumsum(is_group)
        bare = _bare(tokens, length, fillers)
        gaps = jax.vmap(lambda gap: gap_hash(tokens, bare & (gap_of == gap)))(jnp.arange(groups))
        ends = jax.vmap(lambda at: _end_hash(tokens, at))(jnp.arange(tokens.shape[0]))
        return gaps, jnp.where(is_group, ends, 0)

    gaps, ends = jax.jit(jax.vmap(one))(table.tokens, table.length)
    known, known_ends = unique_hashes(gaps), unique_hashes(ends)
    tokens, meant = np.asarray(table.tokens), np.asarray(table.meant.action)
    inside = np.arange(tokens.shape[1]) < np.asarray(table.length)[:, None]
    said = np.zeros((int(meant.max()) + 1, len(order_words)), bool)
    said[np.repeat(meant, inside.sum(axis=1)), tokens[inside]] = True
    foreign = said.any(axis=0) & ~said
    foreign[:, np.asarray(fillers.free | fillers.nouns | order_words)] = False
    return Habits(fillers, order_words, known, known_ends, jnp.asarray(foreign))


def misuse(key: Array, step: StepTable, donor: StepTable, habits: Habits) -> tuple[Array, Array]:
    """Changes a step `[T]` to something that no program has: tokens `[T + ROOM]`, and their number;
    0 if the result may have a meaning or is reserved.

    It inserts the relation of the `donor`, or a part of it, or a word of another action; omits some
    of the relation's own words; replaces the verb by a relation; inserts an order word; or inserts
    a filler between an article and attribute values.
    """
    which, *keys = jax.random.split(key, 1 + len(SHARES))
    kinds = [
        _with_relation(keys[0], step, donor, habits),
        _with_foreign_word(keys[1], step, habits),
        _with_words_left_out(keys[2], step, habits),
        _without_verb(step, donor),
        _with_order_word(keys[4], step, habits),
        _with_filler(keys[5], step, habits),
    ]
    tokens, length = (jnp.stack(parts) for parts in zip(*kinds, strict=True))
    chosen = jax.random.categorical(which, jnp.log(jnp.array(SHARES)))
    tokens, length = tokens[chosen], length[chosen]
    valid = jnp.arange(tokens.shape[0]) < length
    return tokens, jnp.where(is_reserved(tokens, valid), 0, length)


def _groups(step: StepTable) -> Array:
    """The tokens of attribute values: bool `[T]`."""
    return (step.tokens == GROUP_TOKEN) & (jnp.arange(step.tokens.shape[0]) < step.length)


def _relation_gap(step: StepTable) -> Array:
    """Number of descriptions before the relation: "on Y put X" 0, "put X on Y" 1."""
    return jnp.where(step.meant.object < step.meant.reference, 1, 0)


def _relation(step: StepTable) -> Array:
    """The tokens of the relation, with its article and connective: bool `[T]`."""
    groups = _groups(step)
    inside = jnp.arange(step.tokens.shape[0]) < step.length
    return inside & ~groups & (jnp.cumsum(groups) == _relation_gap(step))


def _around_relation(step: StepTable) -> Array:
    """The tokens before which an insertion is inside or next to the relation: bool `[T]`."""
    relation = _relation(step)
    return relation | jnp.concatenate([jnp.zeros(1, bool), relation[:-1]])


def _is_known(tokens: Array, length: Array, gap: Array, habits: Habits) -> Array:
    """Whether the words after `gap` descriptions occur before a description in some sentence."""
    inside = jnp.arange(tokens.shape[0]) < length
    here = jnp.cumsum(inside & (tokens == GROUP_TOKEN)) == gap
    bare = _bare(tokens, length, habits.fillers) & here
    return jnp.isin(gap_hash(tokens, bare), habits.known)


def _with_relation(
    key: Array, step: StepTable, donor: StepTable, habits: Habits
) -> tuple[Array, Array]:
    keys = jax.random.split(key, 4)
    fillers = habits.fillers.free | habits.fillers.nouns
    chosen = _part_of_relation(keys[0], donor, fillers)
    # With a filler before it: "block left of the", "and to the left of the".
    joining, which = jax.random.split(keys[1])
    filler = jax.random.categorical(which, jnp.where(fillers, 0.0, MISSING))
    joined = jax.random.bernoulli(joining) & fillers.any()
    # Directly before a description, "on the | block left of the | blue block"; in or next to the
    # step's own relation; or anywhere.
    position = jnp.arange(step.tokens.shape[0])
    places = jnp.stack([_groups(step), _around_relation(step), position <= step.length])
    places = places[jax.random.randint(keys[2], (), 0, len(places))]
    at = jax.random.categorical(keys[3], jnp.where(places, 0.0, MISSING))
    added = jnp.concatenate([filler[None], donor.tokens])
    tokens, length = _inserted(step, at, added, jnp.concatenate([joined[None], chosen]))
    gap = jnp.sum(_groups(step) & (position < at))
    return tokens, jnp.where(_is_known(tokens, length, gap, habits), 0, length)


def _with_foreign_word(key: Array, step: StepTable, habits: Habits) -> tuple[Array, Array]:
    """A word of another action, in or next to the relation: "to the | top | left of"."""
    which, where = jax.random.split(key)
    foreign = habits.foreign[step.meant.action]
    word = jax.random.categorical(which, jnp.where(foreign, 0.0, MISSING))
    at = jax.random.categorical(where, jnp.where(_around_relation(step), 0.0, MISSING))
    tokens, length = _inserted(step, at, word[None], jnp.ones(1, bool))
    return tokens, jnp.where(foreign.any(), length, 0)


def _with_words_left_out(key: Array, step: StepTable, habits: Habits) -> tuple[Array, Array]:
    """The relation without one to three of its words: "to the" for "to the right of the"."""
    first, size = jax.random.split(key)
    relation = _relation(step)
    order, count = jnp.cumsum(relation) - 1, relation.sum()
    low = jax.random.randint(first, (), 0, jnp.maximum(count, 1))
    out = relation & (order >= low) & (order < low + jax.random.randint(size, (), 1, 4))
    tokens, length = _without(step, out)
    tokens = jnp.pad(tokens, (0, ROOM))
    gap = _relation_gap(step)
    return tokens, jnp.where(_is_known(tokens, length, gap, habits), 0, length)


def _part_of_relation(key: Array, donor: StepTable, fillers: Array) -> Array:
    """The donor's relation, with or without its article, or one to three of its words; in half of
    the cases without some of its fillers: "left of the" for "block left of the". bool `[T]`."""
    ending, thinning, thin, parting, first, size = jax.random.split(key, 6)
    relation = _relation(donor)
    order, count = jnp.cumsum(relation) - 1, relation.sum()
    is_filler = fillers[donor.tokens]
    dropped = jax.random.bernoulli(thinning) & jax.random.bernoulli(thin, shape=relation.shape)
    thinned = relation & ~(is_filler & dropped)
    thinned &= (order < count - jax.random.bernoulli(ending)) | (count == 1)
    low = jax.random.randint(first, (), 0, jnp.maximum(count, 1))
    part = relation & (order >= low) & (order < low + jax.random.randint(size, (), 1, 4))
    use_part = jax.random.bernoulli(parting) & jnp.any(part & ~is_filler)
    chosen = jnp.where(use_part, part, thinned)
    return jnp.where(jnp.any(chosen & ~is_filler), chosen, relation)


def _without_verb(step: StepTable, donor: StepTable) -> tuple[Array, Array]:
    """Two relations and no verb, like "the green block left of the blue one on the white one" taken
    as a step."""
    groups = _groups(step)
    inside = jnp.arange(step.tokens.shape[0]) < step.length
    # The words before the moved object's description contain the verb.
    gap = 1 - _relation_gap(step)
    tokens, length = _without(step, inside & ~groups & (jnp.cumsum(groups) == gap))
    rest = StepTable(tokens, length, step.follows, step.meant)
    at = jnp.argmax(jnp.cumsum(_groups(rest)) == gap + 1)
    return _inserted(rest, at, donor.tokens, _relation(donor))


def _with_order_word(key: Array, step: StepTable, habits: Habits) -> tuple[Array, Array]:
    which, where = jax.random.split(key)
    word = jax.random.categorical(which, jnp.where(habits.order_words, 0.0, MISSING))
    at = jax.random.randint(where, (), 1, step.length + 1)
    tokens, length = _inserted(step, at, word[None], jnp.ones(1, bool))
    return tokens, jnp.where(habits.order_words.any(), length, 0)


def _with_filler(key: Array, step: StepTable, habits: Habits) -> tuple[Array, Array]:
    which, aim = jax.random.split(key)
    fillers = habits.fillers.free | habits.fillers.nouns | habits.order_words
    word = jax.random.categorical(which, jnp.where(fillers, 0.0, MISSING))
    at = jax.random.categorical(aim, jnp.where(_groups(step), 0.0, MISSING))
    tokens, length = _inserted(step, at, word[None], jnp.ones(1, bool))
    is_known = jnp.isin(_end_hash(tokens, at + 1), habits.known_ends)
    return tokens, jnp.where(is_known | ~fillers.any(), 0, length)


def _without(step: StepTable, out: Array) -> tuple[Array, Array]:
    """The step's tokens without those in `out`, and their number."""
    position = jnp.arange(step.tokens.shape[0])
    kept = (position < step.length) & ~out
    tokens = step.tokens[jnp.argsort(~kept, stable=True)]
    return jnp.where(position < kept.sum(), tokens, 0), kept.sum()


def _inserted(step: StepTable, at: Array, added: Array, among: Array) -> tuple[Array, Array]:
    """The step with the tokens of `added` in `among` inserted before token `at`, at most `ROOM`."""
    width = step.tokens.shape[0]
    places = jnp.concatenate([jnp.where(among, at - 0.5, jnp.inf), jnp.arange(width)])
    tokens = jnp.concatenate([added, step.tokens])[jnp.argsort(places, stable=True)]
    tokens = jnp.pad(tokens, (0, ROOM))[: width + ROOM]
    length = jnp.minimum(step.length + among.sum(), width + ROOM)
    return jnp.where(jnp.arange(width + ROOM) < length, tokens, 0), length


def _bare(tokens: Array, length: Array, fillers: Fillers) -> Array:
    """Words that are neither fillers nor nouns directly after attribute values: bool `[T]`."""
    is_group = tokens == GROUP_TOKEN
    behind = jnp.concatenate([jnp.zeros(1, bool), is_group[:-1]])
    is_filler = fillers.free[tokens] | (fillers.nouns[tokens] & behind)
    return (jnp.arange(tokens.shape[0]) < length) & ~is_group & ~is_filler


def _end_hash(tokens: Array, at: Array) -> Array:
    """Hash of the two words before token `at`."""
    position = jnp.arange(tokens.shape[0])
    return gap_hash(tokens + 1, (position < at) & (position >= at - 2))
