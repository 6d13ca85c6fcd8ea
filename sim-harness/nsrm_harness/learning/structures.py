"""How the concept groups of a step may be put together to two descriptions.

A group's values either describe an argument, or with a relation the object described before it, or
in place of an object without values what that is related to: "the block left of the red one". The
relations are those that actions bring about, and then the superlatives.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from nsrm import MAX_RELATIONS

from nsrm_harness.data.near_misses import MOST_GROUPS
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.learning.calibrate import terms
from nsrm_harness.learning.dataset import GROUPS_PER_STEP
from nsrm_harness.learning.model import MATCH_SCORE, MISSING, Heard, Model

CLEAR = 0.766
"""Least cosine at which a relation clearly holds, `nsrm_core::relation::RELATION_CLEAR`."""
NEARER = 1.2
"""Least ratio of two distances at which the shorter one is clearly shorter,
`nsrm_core::relation::CLEARLY_NEARER`."""
STEEP = 0.5
"""Share of a distance that is vertical from which on one object stands on another."""
LEAST_LENGTH = 1e-9
"""Square metres below which a product of two distances is no direction."""
PLAIN = 0
"""The role of a group that describes an argument. Role `1 + k` restricts the description before it
by relation k; role `1 + R + k` stands for an object without values, by what that is related to."""


Table = Any
"""An array of NumPy or of JAX."""


class Structures(NamedTuple):
    """S ways to put at most `MOST_GROUPS` groups together."""

    count: Table
    """Number of groups, `[S]`."""
    roles: Table
    """Role of each group, `[S, G]`; `PLAIN` behind the last."""
    moved: Table
    """Index of the group with which the description of the object to be moved begins, `[S]`."""
    reference: Table
    """The same of the reference."""


@lru_cache
def structures(relations: int) -> Structures:
    """All structures for a domain with so many relations; the first two are those of plain steps,
    with the object to be moved in front and with the reference in front."""
    found: list[tuple[int, list[int], int, int]] = []
    for count in range(GROUPS_PER_STEP, MOST_GROUPS + 1):
        for roles in product(range(1 + 2 * relations), repeat=count):
            heads = [at for at, role in enumerate(roles) if not _restricts(role, relations)]
            if len(heads) != 2 or heads[0] != 0 or not _short_enough(roles, heads):
                continue
            padded = [*roles, *(MOST_GROUPS - count) * [PLAIN]]
            first, second = heads
            found += [(count, padded, first, second), (count, padded, second, first)]
    counts, roles, moved, reference = zip(*found, strict=True)
    return Structures(np.array(counts), np.array(roles), np.array(moved), np.array(reference))


def _restricts(role: int, relations: int) -> bool:
    return 1 <= role <= relations


def _short_enough(roles: tuple[int, ...], heads: list[int]) -> bool:
    ends = [heads[1], len(roles)]
    return all(
        end - head - (roles[head] == PLAIN) <= MAX_RELATIONS
        for head, end in zip(heads, ends, strict=True)
    )


def related(model: Model, locations: Array, camera: Camera) -> Array:
    """`Relate`: how far each object is in the direction in which each action would put it, seen
    from each other one. Locations `[M, 5]` -> cosines `[A, M, M]`; -1 with itself."""
    every = jnp.eye(model.language.action_decoder.weight.shape[0])
    over_others = jax.vmap(model.action.simulator, (None, None, 0))
    over_objects = jax.vmap(over_others, (None, 0, None))
    put = jax.vmap(over_objects, (0, None, None))(every, locations, locations)
    center, goal = (centers(model, each, camera) for each in (locations, put))
    stands, goal = center[:, None] - center[None], goal - center[None, None]
    lengths = jnp.linalg.norm(stands, axis=-1) * jnp.linalg.norm(goal, axis=-1)
    cosines = jnp.sum(stands * goal, axis=-1) / jnp.maximum(lengths, LEAST_LENGTH)
    return jnp.where(jnp.eye(len(locations), dtype=bool), -1.0, cosines)


def directions(model: Model, locations: Array, camera: Camera) -> Array:
    """Where each action would put each object with itself as reference: unit vectors in the world,
    vertical or horizontal. Locations `[M, 5]` -> `[A, M, 3]`."""
    every = jnp.eye(model.language.action_decoder.weight.shape[0])
    over_objects = jax.vmap(model.action.simulator, (None, 0, 0))
    put = jax.vmap(over_objects, (0, None, None))(every, locations, locations)
    moved = centers(model, put, camera) - centers(model, locations, camera)
    moved = moved @ jnp.asarray(camera.pose.rotation()).T
    is_vertical = moved[..., 2:] ** 2 > jnp.sum(moved[..., :2] ** 2, axis=-1, keepdims=True)
    moved = jnp.where(is_vertical == jnp.array([False, False, True]), moved, 0.0)
    return moved / jnp.linalg.norm(moved, axis=-1, keepdims=True)


def centers(model: Model, locations: Array, camera: Camera) -> Array:
    """The centres of objects in the camera's frame: locations `[..., 5]` -> metres `[..., 3]`."""
    return terms(locations, camera, jnp) @ model.camera.weight.T


def remoteness(model: Model, locations: Array, camera: Camera) -> Array:
    """How far each object is from what each of the superlatives means, seen from each other one:
    the distances between centres and their inverses. Locations `[M, 5]` -> `[2, M, M]`."""
    center = centers(model, locations, camera)
    distances = jnp.linalg.norm(center[:, None] - center[None], axis=-1)
    return jnp.stack([distances, 1.0 / jnp.maximum(distances, LEAST_LENGTH)])


def apart(model: Model, locations: Array, camera: Camera) -> Array:
    """Whether objects stand side by side rather than on each other: `[M, 5]` -> `[M, M]`.

    What stands on an object is nearly always the nearest to it, and often so much hidden that no
    action's relation explains it: a superlative would explain what is said about it all the same.
    """
    center = centers(model, locations, camera)
    between = (center[:, None] - center[None]) @ jnp.asarray(camera.pose.rotation()).T
    return jnp.abs(between[..., 2]) < STEEP * jnp.linalg.norm(between, axis=-1)


class Pairs(NamedTuple):
    """What each object is to each other one."""

    cosines: Array
    """`[A, M, M]`, see `related`."""
    remote: Array
    """`[2, M, M]`, see `remoteness`."""
    apart: Array
    """`[M, M]`, see `apart`."""


def pairs(model: Model, locations: Array, camera: Camera) -> Pairs:
    """All of it, for locations `[M, 5]`."""
    found = (each(model, locations, camera) for each in (related, remoteness, apart))
    return Pairs(*found)


def referents(
    structure: Structures, matches: Array, among: Pairs, present: Array
) -> tuple[Array, Array]:
    """The objects that the two descriptions of one structure refer to; -1 for none or several.

    * `matches` `[G, M]`: whether each object fits the values of each group

    A superlative of a single object, or of one that stands on another, shows nothing; nor does a
    chain in which the moved object is described by how far something is from itself.
    """
    cosines, remote, side_by_side = among
    count, roles, moved, reference = structure
    actions, size = cosines.shape[:2]
    relations = actions + len(remote)

    def only(fits: Array, clear: Array) -> Array:
        """The only object that fits, if it does so clearly."""
        at = jnp.argmax(fits)
        return jnp.where((fits.sum() == 1) & clear[at], at, -1)

    def by(relation: Array, anchor: Array, every: Array) -> tuple[Array, Array]:
        """Which of the objects are in the relation, and which clearly are."""
        cosine = cosines[jnp.clip(relation, 0, actions - 1), :, anchor]
        far = remote[jnp.maximum(relation - actions, 0), :, anchor]
        compared = every & (jnp.arange(size) != anchor)
        least = jnp.where(compared, far, jnp.inf).min()
        extreme = compared & (far <= NEARER * least) & (compared.sum() > 1)
        compares, known = relation >= actions, anchor >= 0
        fits = jnp.where(compares, extreme, every & (cosine >= MATCH_SCORE))
        clear = jnp.where(compares, side_by_side[:, anchor], cosine >= CLEAR)
        return fits & known, clear & known

    everywhere = jnp.ones(size, bool)
    pending, anchor = jnp.array(-1), jnp.array(-1)
    meant, compared_with = jnp.full(MOST_GROUPS, -1), jnp.full(MOST_GROUPS, -1)
    for group in reversed(range(MOST_GROUPS)):
        role = roles[group]

        plain = matches[group] & present
        fits, clear = by(pending, anchor, plain)
        own = only(jnp.where(pending >= 0, fits, plain), jnp.where(pending >= 0, clear, everywhere))
        stands = (role - 1) // relations == 1
        other = only(*by((role - 1) % relations, own, present))
        used = group < count
        restricts = (role >= 1) & ~stands
        meant = meant.at[group].set(jnp.where(stands, other, own))
        compares = used & (role >= 1) & ((role - 1) % relations >= actions)
        compared_with = compared_with.at[group].set(jnp.where(compares, own, -1))
        pending = jnp.where(used & restricts, (role - 1) % relations, -1)
        anchor = jnp.where(used & restricts, own, -1)
    group = jnp.arange(MOST_GROUPS)
    own_chain = (group >= moved) & ((group < reference) | (moved > reference))
    around_itself = jnp.any(own_chain & (compared_with >= 0) & (compared_with == meant[moved]))
    return jnp.where(around_itself, -1, meant[moved]), meant[reference]


def explaining_log_probability(heard: Heard, places: Array, programs: Array) -> Array:
    """Log probability that a step means one of the programs that explain its final scene.

    * `places` `[G]`: index of each group token
    * `programs` `[P]`: see `explain.Explained`
    """
    parse, roles = heard.parse, heard.roles[places]
    actions, relations = len(parse.action), roles.shape[1] // 2
    table = structures(relations)
    role = jnp.arange(roles.shape[1])
    # Before the first group there is no description.
    roles = roles.at[0].set(jnp.where((role >= 1) & (role <= relations), MISSING, roles[0]))
    # Those behind the last are masked.
    which = jnp.maximum(programs, 0)
    count, own, moved, reference = (jnp.asarray(column)[which // actions] for column in table)
    chosen = jax.nn.log_softmax(roles)[jnp.arange(MOST_GROUPS), own]
    used = jnp.arange(MOST_GROUPS) < count[:, None]
    objects, references = parse.object[places], parse.reference[places]
    order = jax.nn.log_sigmoid(objects[moved] - objects[reference])
    order += jax.nn.log_sigmoid(references[reference] - references[moved])
    structure = jnp.where(used, chosen, 0.0).sum(axis=1) + order
    every = structure + jax.nn.log_softmax(parse.action)[which % actions]
    return jax.nn.logsumexp(jnp.where(programs >= 0, every, MISSING))
