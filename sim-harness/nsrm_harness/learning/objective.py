"""The loss on the final scene (section IV-E), with discrete choices.

Action, object, reference and split are discrete choices. If their number allows, the loss is the
exact soft minimum under the model's own probabilities,

    -τ log Σ_c π(c) exp(-L(c) / τ),

which credits the choice that explains the final scene; for large τ it becomes the plain
expectation. With τ = 0.05 the actions separated for every seed that was tried; plain
straight-through Gumbel samples merge them for most seeds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.common.toml_file import NO_OTHER_KEYS, PositiveOrZero
from nsrm_harness.learning.model import (
    GROUP_TOKEN,
    MISSING,
    Model,
    Parse,
    Simulator,
    filter_scene,
    unique,
)


@dataclass(frozen=True)
class LossWeights:
    """The weights of `w1 · MSE + w2 · (1 - IoU)`, the paper's hyperparameters."""

    __pydantic_config__ = NO_OTHER_KEYS

    square: PositiveOrZero
    """w1, for the mean squared error over corners (fractions of the image) and depth (metres)."""
    overlap: PositiveOrZero
    """w2, for one minus the intersection over union of the boxes."""


@dataclass(frozen=True)
class Objective:
    """How the loss of a command follows from its final scene."""

    weights: LossWeights
    temperature: float
    """τ of the soft minimum over choices."""
    sample_actions: bool = False
    """Whether `sampled_steps` also samples actions, instead of marginalising them."""


class SceneArrays(NamedTuple):
    """A scene before and after: locations `[M, 5]` (corners, depth) and present objects `[M]`."""

    before: Array
    after: Array
    present: Array


class Grounding(NamedTuple):
    """Log probabilities of one step: of actions `[A]`, of both objects `[M]`.

    The probabilities of the objects sum to the probability that a description has exactly one
    match.
    """

    action: Array
    object: Array
    reference: Array


def area(box: Array) -> Array:
    """Boxes `[..., >= 4]` as x1, y1, x2, y2 -> `[...]`."""
    return jnp.prod(jnp.maximum(box[..., 2:4] - box[..., :2], 0.0), axis=-1)


def intersection(left: Array, right: Array) -> Array:
    """The area that is in both boxes; 0 where they do not meet."""
    low = jnp.maximum(left[..., :2], right[..., :2])
    high = jnp.minimum(left[..., 2:4], right[..., 2:4])
    return jnp.prod(jnp.maximum(high - low, 0.0), axis=-1)


def intersection_over_union(left: Array, right: Array) -> Array:
    """Boxes `[..., >= 4]` as x1, y1, x2, y2 -> `[...]`; 0 where they do not meet."""
    shared = intersection(left, right)
    return shared / jnp.maximum(area(left) + area(right) - shared, 1e-9)


def location_loss(predicted: Array, target: Array, weights: LossWeights) -> Array:
    """Loss of one object: locations `[..., 5]` -> `[...]`."""
    square = jnp.mean((predicted - target) ** 2, axis=-1)
    overlap = 1.0 - intersection_over_union(predicted, target)
    return weights.square * square + weights.overlap * overlap


def scene_loss(predicted: Array, scene: SceneArrays, weights: LossWeights) -> Array:
    """Mean over the present objects: predicted locations `[M, 5]` -> scalar."""
    losses = location_loss(predicted, scene.after, weights)
    return jnp.sum(jnp.where(scene.present, losses, 0.0)) / jnp.sum(scene.present)


def soft_minimum(log_probability: Array, losses: Array, temperature: float) -> Array:
    """`-τ log Σ π exp(-L / τ)` over all axes; π need not sum to 1."""
    return -temperature * jax.nn.logsumexp(log_probability - losses / temperature)


def entropy(log_probability: Array) -> Array:
    """Entropy in nats; impossible choices (`MISSING`) contribute nothing."""
    probability = jnp.exp(log_probability)
    return -jnp.sum(probability * jnp.where(probability > 0.0, log_probability, 0.0))


def reinforce(
    key: Array,
    log_probability: Array,
    losses_of: Callable[[Array], Array],
    samples: int,
    spread: Array | float,
) -> Array:
    """The expected loss by sampling, with REINFORCE's gradient (section IV-E) for the sampled
    choices.

    * `log_probability` `[T]`: log probability of each choice
    * `losses_of`: maps indices of choices `[samples]` to losses, whose own gradients count, too
    * `samples`: at least two; each is compared with the mean of the others, which has the same
      expectation and is independent of it, so the gradient is unbiased
    * `spread`: weight of the entropy, which keeps all choices possible

    The value is the mean loss of the samples minus the weighted entropy.
    """
    chosen = jax.random.categorical(key, log_probability, shape=(samples,))
    losses = losses_of(chosen)
    fixed = jax.lax.stop_gradient(losses)
    advantage = fixed - (fixed.sum() - fixed) / (samples - 1)
    score = jnp.mean(advantage * log_probability[chosen])
    loss = losses.mean() + score - jax.lax.stop_gradient(score)
    return loss - spread * entropy(log_probability)


def ground(parse: Parse, tokens: Array, groups: Array, similarities: Array, present: Array):
    """Converts a parsed step to log probabilities of actions and objects.

    * `tokens` `[T]`: the step's tokens; its n-th group token represents `groups[n]`
    * `groups` `[G, K]`: concepts of each group, padded with -1
    * `similarities` `[M, C]`: cosine of each object with each concept

    An argument's object has probability Σ_group π(group) · Unique(Filter(group)): the choice of the
    group is marginalised.
    """
    scores = jax.vmap(filter_scene, (None, 0))(similarities, groups)
    meant = jax.vmap(unique, (0, None))(scores, present)
    order = jnp.cumsum(tokens == GROUP_TOKEN) - 1
    by_token = meant[jnp.clip(order, 0, groups.shape[0] - 1)]

    def choose(logits: Array) -> Array:
        # A token that is not a group has probability 0; keep its gradient finite.
        pointer = jnp.where(logits <= MISSING / 2, MISSING, jax.nn.log_softmax(logits))
        return jax.nn.logsumexp(pointer[:, None] + by_token, axis=0)

    action = jax.nn.log_softmax(parse.action)
    return Grounding(action, choose(parse.object), choose(parse.reference))


def exact_step(
    simulator: Callable[[Array, Array, Array], Array],
    grounding: Grounding,
    scene: SceneArrays,
    objective: Objective,
    exploration: Array | float = 0.0,
) -> Array:
    """Soft minimum over all actions, objects and references of one step.

    `exploration`: share of the action probability that is uniform, so that no action dies before it
    has found its purpose.
    """
    weights, count = objective.weights, grounding.action.shape[0]
    even = jnp.log(jnp.maximum(exploration, 1e-9) / count)
    action = jnp.logaddexp(jnp.log1p(-exploration) + grounding.action, even)
    actions = jnp.eye(count)
    over_references = jax.vmap(simulator, (None, None, 0))
    over_objects = jax.vmap(over_references, (None, 0, None))
    moved = jax.vmap(over_objects, (0, None, None))(actions, scene.before, scene.before)
    still = jnp.where(scene.present, location_loss(scene.before, scene.after, weights), 0.0)
    placed = location_loss(moved, scene.after[None, :, None], weights)
    losses = still.sum() - still[None, :, None] + placed
    log_probability = (
        action[:, None, None] + grounding.object[None, :, None] + grounding.reference[None, None, :]
    )
    possible = scene.present[:, None] & scene.present[None, :]
    log_probability = jnp.where(possible, log_probability, MISSING)
    return soft_minimum(log_probability, losses / scene.present.sum(), objective.temperature)


def straight_through(key: Array, log_probability: Array) -> Array:
    """Gumbel-softmax sample `[M]`: one-hot forward, the soft sample's gradient backward."""
    noise = jax.random.gumbel(key, log_probability.shape)
    soft = jax.nn.softmax(log_probability + noise)
    hard = jax.nn.one_hot(jnp.argmax(soft), soft.shape[0])
    return hard + soft - jax.lax.stop_gradient(soft)


def move(
    simulator: Simulator, action: Array, chosen: Array, reference: Array, locations: Array
) -> Array:
    """Executes one step: one-hot choices `[A]`, `[M]`, `[M]` on locations `[M, 5]`."""
    placed = simulator(action, chosen @ locations, reference @ locations)
    return locations + chosen[:, None] * (placed - locations)


def sampled_steps(
    key: Array, model: Model, steps: list[Grounding], scene: SceneArrays, objective: Objective
) -> Array:
    """Loss with objects by straight-through Gumbel samples, and the actions of all steps
    marginalised exactly, or sampled like the objects."""
    simulator = model.action.simulator
    locations = scene.before[None]
    log_probability = jnp.zeros(1)
    for at, step in zip(jax.random.split(key, len(steps)), steps, strict=True):
        first, second = jax.random.split(at)
        actions, action = jnp.eye(step.action.shape[0]), step.action
        if objective.sample_actions:
            sampled = straight_through(jax.random.fold_in(at, 2), step.action)
            actions, action = sampled[None], jnp.zeros(1)
        chosen = straight_through(first, step.object)
        reference = straight_through(second, step.reference)
        run = jax.vmap(move, (None, 0, None, None, None))
        run = jax.vmap(run, (None, None, None, None, 0))
        after = run(simulator, actions, chosen, reference, locations)
        locations = after.reshape(-1, *scene.before.shape)
        # Each description of a demonstration has exactly one match.
        matched = jax.nn.logsumexp(step.object) + jax.nn.logsumexp(step.reference)
        log_probability = (log_probability[:, None] + action[None] + matched).reshape(-1)
    losses = jax.vmap(scene_loss, (0, None, None))(locations, scene, objective.weights)
    return soft_minimum(log_probability, losses, objective.temperature)
