"""Finds the programs that explain a demonstration, whatever its sentence says: which action moved
which described object to which other one.

Perception and action simulator of a trained model execute all programs that are possible with the
descriptions in a sentence, and the final scene shows which ones may have been meant. So new words
and relations need no other teacher than demonstrations: a model that knows what objects look like
and what actions do learns what is said.

A sentence whose demonstration one action explains is a step; its descriptions may be put together
in many ways (`structures`), of which several may explain it by chance. One with four descriptions
may instead have two steps, each with two plain ones. Where both explain it, as when the second step
moves the same object again, it is left out.
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.learning.config import TrainingConfig
from nsrm_harness.learning.dataset import GROUPS_PER_STEP, TrainingSet
from nsrm_harness.learning.decode import scenes, see_all
from nsrm_harness.learning.model import MATCH_SCORE, MISSING, Model, filter_scene
from nsrm_harness.learning.objective import (
    SceneArrays,
    area,
    intersection,
    location_loss,
    scene_loss,
)
from nsrm_harness.learning.structures import (
    MOST_GROUPS,
    Structures,
    pairs,
    referents,
    structures,
)

CHUNK = 512
"""Number of sentences per batch."""
MARGIN = 0.02
"""Smallest difference between the losses of what explains a final scene and what does not."""
NESTED = 0.95
"""Least share of the smaller of two boxes that lies in the other one if they are of an object that
has not moved."""
MOST_PROGRAMS = 16
"""What more programs explain teaches nothing."""


class Explained(NamedTuple):
    """R steps whose final scene some program explains."""

    sentence: np.ndarray
    """Index of the sentence, `[R]`."""
    step: np.ndarray
    """Index of the step in it, `[R]`."""
    programs: np.ndarray
    """What explains it, `[R, MOST_PROGRAMS]`: A times the number of one of `structures`, plus the
    action's; -1 behind the last."""


def explain(model: Model, data: TrainingSet, config: TrainingConfig, camera: Camera) -> Explained:
    """The steps of the sentences with one and two steps that some program explains.

    `camera`: that of the scenes
    """
    similarities = see_all(model, data)
    counts = data.sentences.group_count
    groups = np.full((len(data), MOST_GROUPS, data.sentences.groups.shape[2]), -1)
    width = min(MOST_GROUPS, data.sentences.groups.shape[1])
    groups[:, :width] = data.sentences.groups[:, :width]
    few = np.flatnonzero((counts >= GROUPS_PER_STEP) & (counts <= MOST_GROUPS))

    def batches(rows: np.ndarray):
        for start in range(0, len(rows), CHUNK):
            # The last batch is filled up with its last row: one shape is compiled.
            some = rows[np.arange(start, start + CHUNK).clip(max=len(rows) - 1)]
            yield some, len(rows) - start

    actions, size = model.language.action_decoder.weight.shape[0], data.present.shape[1]
    moves = np.zeros((len(data), actions, size, size), bool)
    for some, _ in batches(few):
        moves[some] = _moves(model, scenes(data, some), config)
    single = np.any(moves, axis=(1, 2, 3))
    parts: list[Explained] = []
    for some, count in batches(few[counts[few] == 2 * GROUPS_PER_STEP]):
        best, loss, next_loss = _two_steps(
            model,
            jnp.asarray(groups[some]),
            jnp.asarray(similarities[some]),
            scenes(data, some),
            config,
        )
        some, fits = some[:count], np.asarray(loss)[:count] <= config.explained
        sure = fits & np.asarray(next_loss > loss + MARGIN)[:count] & ~single[some]
        steps = np.stack(np.unravel_index(np.asarray(best)[:count], (2 * actions,) * 2), axis=1)
        for number in range(2):
            found = _plain(steps[:, number], actions, relations_of(model))
            parts.append(_explained(some[sure], number, found[sure]))
        single[some] &= ~fits
    for number in range(GROUPS_PER_STEP, MOST_GROUPS + 1):
        for some, count in batches(few[single[few] & (counts[few] == number)]):
            found = _programs(
                model,
                jnp.asarray(groups[some]),
                jnp.asarray(similarities[some]),
                scenes(data, some),
                jnp.asarray(moves[some]),
                camera,
                number,
            )
            found = np.asarray(found)[:count].reshape(len(some[:count]), -1)
            parts.append(_explained(some[:count], 0, found))
    return Explained(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _explained(rows: np.ndarray, step: int, programs: np.ndarray) -> Explained:
    """The steps that a few programs explain: rows `[N]`, whether each program does `[N, S·A]`."""
    counts = programs.sum(axis=1)
    kept = (counts > 0) & (counts <= MOST_PROGRAMS)
    row, program = np.nonzero(programs[kept])
    listed = np.full((int(kept.sum()), MOST_PROGRAMS), -1, np.int32)
    first = np.cumsum(counts[kept]) - counts[kept]
    listed[row, np.arange(len(row)) - first[row]] = program
    return Explained(rows[kept], np.full(len(listed), step), listed)


def relations_of(model: Model) -> int:
    """The number of relations that descriptions may have."""
    return len(model.language.relation_decoder.weight) // 2


def _plain(steps: np.ndarray, actions: int, relations: int) -> np.ndarray:
    """Plain programs by number, 2·action + (0 if the first description is of the object to be
    moved), as for `_explained`."""
    found = np.zeros((len(steps), len(structures(relations).count), actions), bool)
    found[np.arange(len(steps)), steps % 2, steps // 2] = True
    return found.reshape(len(steps), -1)


@eqx.filter_jit
def _moves(model: Model, scene: SceneArrays, config: TrainingConfig) -> Array:
    """Which action, of which object to which other one, explains each scene: `[N, A, M, M]`."""
    weights = config.loss
    actions = jnp.eye(model.language.action_decoder.weight.shape[0])

    def one(scene: SceneArrays) -> Array:
        over_references = jax.vmap(model.action.simulator, (None, None, 0))
        over_objects = jax.vmap(over_references, (None, 0, None))
        moved = jax.vmap(over_objects, (0, None, None))(actions, scene.before, scene.before)
        still = location_loss(scene.before, scene.after, weights)
        # What another object covers, or does no longer, seems to shrink or to grow.
        still = jnp.where(_nested(scene.before, scene.after) | ~scene.present, 0.0, still)
        placed = location_loss(moved, scene.after[None, :, None], weights)
        losses = still.sum() - still[None, :, None] + placed
        possible = scene.present[:, None] & scene.present[None]
        possible &= ~jnp.eye(len(scene.present), dtype=bool)
        losses = jnp.where(possible, losses / scene.present.sum(), jnp.inf)
        return losses <= jnp.minimum(losses.min() + MARGIN, config.explained)

    return jax.vmap(one)(scene)


def _nested(left: Array, right: Array) -> Array:
    """Whether of two boxes `[..., >= 4]` one contains almost all of the other."""
    return intersection(left, right) > NESTED * jnp.minimum(area(left), area(right))


@eqx.filter_jit
def _programs(
    model: Model,
    groups: Array,
    similarities: Array,
    scene: SceneArrays,
    moves: Array,
    camera: Camera,
    count: int,
) -> Array:
    """Which of `structures` with which action explain each scene, for steps with `count` groups:
    `[N, S, A]`.

    `moves`: see `_moves`
    """
    table = structures(relations_of(model))
    used = np.flatnonzero(table.count == count)
    every = Structures(*(jnp.asarray(column[used]) for column in table))

    def one(groups: Array, similarities: Array, scene: SceneArrays, moves: Array) -> Array:
        matches = jax.vmap(filter_scene, (None, 0))(similarities, groups) >= MATCH_SCORE
        among = pairs(model, scene.before, camera)
        refers = jax.vmap(referents, (0, None, None, None))
        moved, reference = refers(every, matches, among, scene.present)
        explains = moves[:, moved, reference].T & ((moved >= 0) & (reference >= 0))[:, None]
        return jnp.zeros((len(table.count), explains.shape[1]), bool).at[used].set(explains)

    return jax.vmap(one)(groups, similarities, scene, moves)


@eqx.filter_jit
def _two_steps(
    model: Model, groups: Array, similarities: Array, scene: SceneArrays, config: TrainingConfig
) -> tuple[Array, Array, Array]:
    """The best of all plain programs of two steps, its loss, and that of the next best one. Each
    step has the number 2·action + (0 if its first description is of the object to be moved)."""
    actions = model.language.action_decoder.weight.shape[0]

    def one(groups: Array, similarities: Array, scene: SceneArrays) -> tuple[Array, Array, Array]:
        scores = jax.vmap(filter_scene, (None, 0))(similarities, groups)
        objects = jnp.argmax(jnp.where(scene.present, scores, MISSING), axis=1)

        def after(locations: Array, step: Array, first: int) -> Array:
            swapped = step % 2
            moved = jnp.where(swapped, objects[first + 1], objects[first])
            reference = jnp.where(swapped, objects[first], objects[first + 1])
            action = jax.nn.one_hot(step // 2, actions)
            placed = model.action.simulator(action, locations[moved], locations[reference])
            return locations.at[moved].set(placed)

        every = jnp.arange(2 * actions)
        once = jax.vmap(lambda step: after(scene.before, step, 0))(every)
        twice = jax.vmap(
            lambda locations: jax.vmap(lambda step: after(locations, step, GROUPS_PER_STEP))(every)
        )(once)
        loss = jax.vmap(jax.vmap(lambda locations: scene_loss(locations, scene, config.loss)))
        least, places = jax.lax.top_k(-loss(twice).reshape(-1), 2)
        return places[0], -least[0], -least[1]

    return jax.vmap(one)(groups, similarities, scene)
