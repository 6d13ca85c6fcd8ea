"""Losses of one demonstration or of one confirmed step, of which the stages take the mean."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.learning.config import REINFORCE, TrainingConfig
from nsrm_harness.learning.dataset import GROUPS_PER_STEP
from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.misuse import Habits, misuse
from nsrm_harness.learning.model import GROUP_TOKEN, MISSING, Model, Splitter
from nsrm_harness.learning.nonsense import is_reserved, nonsense
from nsrm_harness.learning.objective import (
    Grounding,
    SceneArrays,
    entropy,
    exact_step,
    ground,
    reinforce,
    sampled_steps,
    soft_minimum,
)
from nsrm_harness.learning.splits import (
    TokenizedCommand,
    end_log_probability,
    split_log_probability,
    step_tokens,
)


class Demonstration(NamedTuple):
    """One demonstration: its command, its scene, the indices of its crops `[M]`, and the usual end
    of its first step."""

    command: TokenizedCommand
    scene: SceneArrays
    crop_of: Array
    usual_end: Array


def ground_step(
    model: Model,
    demonstration: Demonstration,
    similarities: Array,
    first: Array,
    end: Array,
    width: int | None = None,
) -> Grounding:
    """Parses and grounds the step with the tokens `first..end` of a command.

    * `similarities` `[M, C]`: cosine of each object with each concept
    * `width`: see `step_tokens`
    """
    tokens, valid, groups = step_tokens(demonstration.command, first, end, width)
    parse = model.language.parse(tokens, valid)
    return ground(parse, tokens, groups, similarities, demonstration.scene.present)


def one_step_loss(
    key: Array,
    model: Model,
    demonstration: Demonstration,
    similarities: Array,
    config: TrainingConfig,
    exploration: Array | None = None,
) -> Array:
    """Loss of a one-step command: objects are sampled or, with `exploration`, all marginalised."""
    scene, length = demonstration.scene, demonstration.command.length
    step = ground_step(model, demonstration, similarities, jnp.array(0), length)
    objective = config.objective
    if exploration is not None and not objective.sample_actions:
        return exact_step(model.action.simulator, step, scene, objective, exploration)
    return sampled_steps(key, model, [step], scene, objective)


def nonsense_loss(key: Array, model: Model, tokens: Array, length: Array, known: Array) -> Array:
    """Divergence, in nats, of the action probabilities of a meaningless step from uniform.

    * `tokens` `[T]`: the step's tokens, of which the first `length` count
    * `known`: see `nonsense`
    """
    valid = jnp.arange(tokens.shape[0]) < length
    tokens, valid = nonsense(key, tokens, valid, known, model.language.embedding.weight.shape[0])
    actions = jax.nn.log_softmax(model.language.parse(tokens, valid).action)
    return -actions.mean() - jnp.log(actions.shape[0])


class TwoSteps(NamedTuple):
    """A command of two steps, for the losses of its splits."""

    model: Model
    demonstration: Demonstration
    similarities: Array
    config: TrainingConfig
    width: int
    """Largest number of tokens of a step."""

    def possible(self, log_probability: Array) -> Array:
        """Log probabilities of splits, without those that leave a step without two objects."""
        command = self.demonstration.command
        position = jnp.arange(log_probability.shape[0])
        is_group = (command.tokens == GROUP_TOKEN) & (position < command.length)
        groups_before = jnp.cumsum(is_group)
        return jnp.where(groups_before == GROUPS_PER_STEP, log_probability, MISSING)

    def losses(self, key: Array, splits: Array) -> Array:
        """Of carrying out what each split makes of the command, and of where it ends the first
        step."""
        carried_out = jax.vmap(lambda split: self._carried_out(key, split))(splits)
        unusual = jnp.abs(splits - self.demonstration.usual_end)
        return carried_out + self.config.unusual_end * unusual

    def _carried_out(self, key: Array, split: Array) -> Array:
        demonstration = self.demonstration
        ends = jnp.stack([split + 1, demonstration.command.length])
        both = jax.vmap(
            lambda first, end: ground_step(
                self.model, demonstration, self.similarities, first, end, self.width
            )
        )(jnp.stack([0, split + 1]), ends)
        steps = [jax.tree.map(lambda a, at=at: a[at], both) for at in range(len(ends))]
        objective = self.config.objective
        return sampled_steps(key, self.model, steps, demonstration.scene, objective)

    def kept_whole(self, split: Array) -> Array:
        """Log probability that the second step is not split again."""
        command = self.demonstration.command
        tokens, _, _ = step_tokens(command, split + 1, command.length, self.width)
        length = command.length - split - 1
        return end_log_probability(self.model.language.splitter, tokens, length)[length - 1]


def two_step_loss(key: Array, steps: TwoSteps, known: Array) -> Array:
    """Loss of a command of two steps over its likeliest splits.

    * `known`: see `nonsense`
    """
    model, config, command = steps.model, steps.config, steps.demonstration.command
    key, saying = jax.random.split(key)
    log_probability = split_log_probability(model.language.splitter, command, jnp.array(0))
    possible = steps.possible(log_probability)
    likeliest, positions = jax.lax.top_k(possible, config.splits)
    if config.split_gradient == REINFORCE:
        sampling, key = jax.random.split(key)

        def losses_of(sampled: Array) -> Array:
            losses = steps.losses(key, sampled)
            return jnp.where(possible[sampled] > MISSING / 2, losses, config.failed_split)

        loss = reinforce(sampling, log_probability, losses_of, config.split_samples, 0.0)
        loss -= config.temperature * steps.kept_whole(positions[0])
    else:
        # The remainder of a split must not be split again: a split that makes this hard is bad.
        likeliest += jax.vmap(steps.kept_whole)(positions)
        loss = soft_minimum(likeliest, steps.losses(key, positions), config.temperature)
    # Connectives begin the second step, and so they do in meaningless steps that follow one.
    first = positions[0] + 1
    second, _, _ = step_tokens(command, first, command.length, steps.width)
    heap = nonsense_loss(saying, model, second, command.length - first, known)
    return loss + config.indecision * entropy(log_probability) + config.nonsense * heap


def end_loss(key: Array, splitter: Splitter, step: StepTable, following: StepTable) -> Array:
    """Surprise at the end of a step that is followed by another one or, in half of the cases, by
    none.

    Demonstrations have at most two steps; commands may have more, and each step but the last is
    then followed by another one.
    """
    width, room = step.tokens.shape[0], following.tokens.shape[0]
    position = jnp.arange(width + room)
    behind = jnp.where(jax.random.bernoulli(key), following.length, 0)
    tokens = jnp.where(
        position < step.length,
        step.tokens[jnp.clip(position, 0, width - 1)],
        following.tokens[jnp.clip(position - step.length, 0, room - 1)],
    )
    return -end_log_probability(splitter, tokens, step.length + behind)[step.length - 1]


class Said(NamedTuple):
    """Data about the words of all steps."""

    habits: Habits
    known: Array
    """Hashes of the words before descriptions; see `nonsense`."""


def misuse_loss(key: Array, model: Model, step: StepTable, donor: StepTable, said: Said) -> Array:
    """Like `nonsense_loss`, for a step with something that no program has; see `misuse`."""
    tokens, length = misuse(key, step, donor, said.habits)
    valid = jnp.arange(tokens.shape[0]) < length
    actions = jax.nn.log_softmax(model.language.parse(tokens, valid).action)
    return jnp.where(length > 0, -actions.mean() - jnp.log(actions.shape[0]), 0.0)


def reordered_loss(
    key: Array, splitter: Splitter, step: StepTable, other: StepTable, habits: Habits
) -> Array:
    """Penalty, in nats, if the splitter is sure that `step` ends where `other` begins with an order
    word: "put the red block on the blue one first put …" may mean either order.

    0 if `other` has a connective: the parser itself is then unsure of it.
    """
    width = step.tokens.shape[0]
    position = jnp.arange(2 * width)
    word = jax.random.categorical(key, jnp.where(habits.order_words, 0.0, MISSING))
    behind = position - step.length - 1
    tokens = jnp.where(behind == -1, word, other.tokens[jnp.clip(behind, 0, width - 1)])
    tokens = jnp.where(behind < -1, step.tokens[jnp.clip(position, 0, width - 1)], tokens)
    length = step.length + 1 + other.length
    ends = end_log_probability(splitter, tokens, length)
    # h and 1 - h of the hazard at the step's last token, given no earlier end.
    here = ends[step.length - 1]
    later = jax.nn.logsumexp(jnp.where(position >= step.length, ends, MISSING))
    before = jnp.logaddexp(here, later)
    loss = before - (here + later) / 2 - jnp.log(2.0)
    counts = ~other.follows & habits.order_words.any()
    second = (position > step.length - 1) & (position < length)
    counts &= ~is_reserved(jnp.where(second, tokens, 0), second)
    return jnp.where(counts, loss, 0.0)
