"""Finds the program that explains a demonstration, whatever its sentence says: which action moved
which described object to which other one.

A sentence of one step has two descriptions, so there are as many programs as twice the actions;
of two steps, the square of that. Perception and action simulator of a trained model execute all of
them, and the final scene shows which one was meant. So new words need no other teacher than
demonstrations: a model that knows what objects look like and what actions do learns what is said.
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.learning.config import TrainingConfig
from nsrm_harness.learning.dataset import GROUPS_PER_STEP, TrainingSet
from nsrm_harness.learning.decode import scenes, see_all
from nsrm_harness.learning.model import MISSING, Model, filter_scene
from nsrm_harness.learning.objective import SceneArrays, scene_loss

CHUNK = 512
"""Number of sentences per batch."""
STEPS = 2
"""Largest number of steps of a sentence: more would be too many programs."""
MARGIN = 0.02
"""Smallest difference to the loss of the next best program."""


class Explained(NamedTuple):
    """R sentences whose final scene only one program explains."""

    sentence: np.ndarray
    """Index of the sentence, `[R]`."""
    action: np.ndarray
    """Action of each step, `[R, 2]`."""
    moved_first: np.ndarray
    """Whether a step's first description is that of the object to be moved, bool `[R, 2]`."""


def explain(model: Model, data: TrainingSet, config: TrainingConfig) -> Explained:
    """The sentences of one and two steps that a program explains, with that program."""
    similarities = see_all(model, data)
    counts = data.sentences.group_count
    chosen = np.flatnonzero((counts == GROUPS_PER_STEP) | (counts == STEPS * GROUPS_PER_STEP))
    groups = np.full((len(data), STEPS * GROUPS_PER_STEP, data.sentences.groups.shape[2]), -1)
    width = min(groups.shape[1], data.sentences.groups.shape[1])
    groups[:, :width] = data.sentences.groups[:, :width]
    found: list[tuple[np.ndarray, ...]] = []
    for start in range(0, len(chosen), CHUNK):
        rows = chosen[np.arange(start, start + CHUNK).clip(max=len(chosen) - 1)]
        parts = _explain(
            model,
            jnp.asarray(groups[rows]),
            jnp.asarray(counts[rows] > GROUPS_PER_STEP),
            jnp.asarray(similarities[rows]),
            scenes(data, rows),
            config,
        )
        found.append(tuple(np.asarray(part)[: len(chosen) - start] for part in parts))
    best, loss, next_loss = (np.concatenate(parts) for parts in zip(*found, strict=True))
    sure = (loss <= config.explained) & (next_loss > loss + MARGIN)
    actions = model.language.action_decoder.weight.shape[0]
    steps = np.stack(np.unravel_index(best[sure], (2 * actions,) * STEPS), axis=1)
    return Explained(chosen[sure], steps // 2, steps % 2 == 0)


@eqx.filter_jit
def _explain(
    model: Model,
    groups: Array,
    is_double: Array,
    similarities: Array,
    scene: SceneArrays,
    config: TrainingConfig,
) -> tuple[Array, Array, Array]:
    """The best of all programs of two steps, its loss, and that of the next best one; of one step,
    those that differ only in the second step count as one."""
    actions = model.language.action_decoder.weight.shape[0]

    def one(
        groups: Array, is_double: Array, similarities: Array, scene: SceneArrays
    ) -> tuple[Array, Array, Array]:
        scores = jax.vmap(filter_scene, (None, 0))(similarities, groups)
        objects = jnp.argmax(jnp.where(scene.present, scores, MISSING), axis=1)

        def after(locations: Array, step: Array, first: int) -> Array:
            """The locations after the step number 2·action + (0 if the first object moves)."""
            swapped = step % 2
            moved = jnp.where(swapped, objects[first + 1], objects[first])
            reference = jnp.where(swapped, objects[first], objects[first + 1])
            action = jax.nn.one_hot(step // 2, actions)
            placed = model.action.simulator(action, locations[moved], locations[reference])
            return locations.at[moved].set(placed)

        def loss(locations: Array) -> Array:
            return scene_loss(locations, scene, config.loss)

        every = jnp.arange(2 * actions)
        once = jax.vmap(lambda step: after(scene.before, step, 0))(every)
        twice = jax.vmap(
            lambda locations: jax.vmap(lambda step: after(locations, step, GROUPS_PER_STEP))(every)
        )(once)
        # The second step of a sentence with one step is always the first in the list.
        single = jnp.full(twice.shape[:2], jnp.inf).at[:, 0].set(jax.vmap(loss)(once))
        losses = jnp.where(is_double, jax.vmap(jax.vmap(loss))(twice), single).reshape(-1)
        least, places = jax.lax.top_k(-losses, 2)
        return places[0], -least[0], -least[1]

    return jax.vmap(one)(groups, is_double, similarities, scene)
