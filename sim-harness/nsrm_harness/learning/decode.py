"""Decodes the model without sampling, like the core, but for many scenes at once.

It is used between stages of training and for golden vectors; metrics come from the core
(`evaluation.metrics`).
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from nsrm import MAX_STEPS

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.learning.config import TrainingConfig
from nsrm_harness.learning.dataset import GROUPS_PER_STEP, TrainingSet, roomy
from nsrm_harness.learning.model import GROUP_TOKEN, MISSING, Model, Parse, filter_scene
from nsrm_harness.learning.objective import SceneArrays, move, scene_loss
from nsrm_harness.learning.splits import TokenizedCommand, split_log_probability, step_tokens

CHUNK = 128
"""Number of rows per batch."""
NEAR_BEST = 0.02
"""A split whose loss exceeds the smallest by at most this much counts as good."""


class NothingPlannedError(HarnessError):
    """A model that can execute no command of the training data."""


class Choices(NamedTuple):
    """Hard choices of each step: indices; the first `count` steps are valid."""

    action: Array
    object: Array
    reference: Array
    count: Array


class SplitTable(NamedTuple):
    """For a command from token `first` on, the loss if its step ends after each token `[T]`."""

    command: TokenizedCommand
    first: Array
    losses: Array


def commands(data: TrainingSet, chosen: np.ndarray) -> TokenizedCommand:
    """The chosen sentences with a leading axis."""
    s = data.sentences
    return TokenizedCommand(
        *(jnp.asarray(a[chosen]) for a in (s.tokens, s.length, s.groups, s.group_count))
    )


def scenes(data: TrainingSet, chosen: np.ndarray) -> SceneArrays:
    """The chosen scenes with a leading axis."""
    return SceneArrays(*(jnp.asarray(a[chosen]) for a in (data.before, data.after, data.present)))


def choose_step(
    model: Model,
    command: TokenizedCommand,
    similarities: Array,
    present: Array,
    first: Array,
    end: Array,
) -> tuple[Array, Array, Array]:
    """Action, object and reference of the step with the tokens `first..end`."""
    tokens, valid, groups = step_tokens(command, first, end)
    parse = model.language.parse(tokens, valid)
    order = jnp.cumsum(tokens == GROUP_TOKEN) - 1

    def pick(logits: Array) -> Array:
        scores = filter_scene(similarities, groups[order[jnp.argmax(logits)]])
        return jnp.argmax(jnp.where(present, scores, MISSING))

    return jnp.argmax(parse.action), pick(parse.object), pick(parse.reference)


@eqx.filter_jit
def _carry_out(
    model: Model, command: TokenizedCommand, similarities: Array, scene: SceneArrays, bounds: Array
) -> tuple[Choices, Array]:
    """Executes commands split at `bounds` `[R, 3]`: choices and the final locations `[R, M, 5]`.

    The first step is `bounds[0]..bounds[1]`, the second goes up to `bounds[2]` if that is larger.
    """

    def one(command, similarities, scene, bounds):
        locations, steps = scene.before, []
        for first, end in ((bounds[0], bounds[1]), (bounds[1], bounds[2])):
            step = choose_step(model, command, similarities, scene.present, first, end)
            hot = [
                jax.nn.one_hot(index, size)
                for index, size in zip(
                    step,
                    (model.language.action_decoder.weight.shape[0], len(locations), len(locations)),
                    strict=True,
                )
            ]
            moved = move(model.action.simulator, hot[0], hot[1], hot[2], locations)
            locations = jnp.where(first < end, moved, locations)
            steps.append(step)
        action, chosen, reference = (jnp.stack(parts) for parts in zip(*steps, strict=True))
        count = 1 + (bounds[2] > bounds[1])
        return Choices(action, chosen, reference, count), locations

    return jax.vmap(one)(command, similarities, scene, bounds)


@eqx.filter_jit
def _see(model: Model, crops: Array) -> Array:
    return jax.vmap(lambda crop: model.vision.similarities(model.vision.encode(crop)))(crops)


def see_all(model: Model, data: TrainingSet) -> np.ndarray:
    """Cosines of every object with every concept, `[N, M, C]`."""
    step = 16 * CHUNK
    parts = []
    for start in range(0, len(data.crops), step):
        crops = data.crops[start : start + step]
        padded = np.pad(crops, ((0, step - len(crops)), (0, 0), (0, 0), (0, 0)))
        parts.append(np.asarray(_see(model, jnp.asarray(padded)))[: len(crops)])
    return np.concatenate(parts)[data.crop_of]


def carry_out(
    model: Model,
    data: TrainingSet,
    similarities: np.ndarray,
    episodes: np.ndarray,
    bounds: np.ndarray,
) -> tuple[Choices, np.ndarray]:
    """Executes the commands of `episodes` `[R]` split at `bounds` `[R, 3]`; see `_carry_out`."""
    results = []
    for start in range(0, len(episodes), CHUNK):
        rows = np.arange(start, start + CHUNK).clip(max=len(episodes) - 1)
        at = episodes[rows]
        seen, cuts = jnp.asarray(similarities[at]), jnp.asarray(bounds[rows])
        result = _carry_out(model, commands(data, at), seen, scenes(data, at), cuts)
        keep = min(CHUNK, len(episodes) - start)
        results.append(jax.tree.map(lambda a, keep=keep: np.asarray(a)[:keep], result))
    return jax.tree.map(lambda *parts: np.concatenate(parts), *results)


@eqx.filter_jit
def _losses(locations: Array, scene: SceneArrays, config: TrainingConfig) -> Array:
    return jax.vmap(lambda at, scene: scene_loss(at, scene, config.loss))(locations, scene)


def split_table(
    model: Model, data: TrainingSet, similarities: np.ndarray, config: TrainingConfig
) -> SplitTable:
    """Losses of all splits of commands with one and two steps, and of the remainders of good
    splits.

    A split that leaves a part with fewer than two groups cannot be executed.
    """
    one, two = data.select(1), data.select(2)
    tokens, length = data.sentences.tokens, data.sentences.length
    position = np.arange(tokens.shape[1])
    inside = position < length[:, None]
    seen = np.cumsum((tokens == GROUP_TOKEN) & inside, axis=1)
    whole = position == length[:, None] - 1
    possible = ((seen == GROUPS_PER_STEP) & inside) | whole
    row, split = np.nonzero(possible[two])
    episodes = two[row]
    bounds = np.stack([np.zeros_like(split), split + 1, length[episodes]], axis=1)
    _, locations = carry_out(model, data, similarities, episodes, bounds)
    found = np.asarray(_losses(jnp.asarray(locations), scenes(data, episodes), config))
    losses = np.full(tokens.shape, config.failed_split, np.float32)
    losses[whole] = 0.0
    remainders = losses.copy()
    least = np.full(len(data), np.inf)
    np.minimum.at(least, episodes, found)
    unusual = np.abs(split - data.sentences.usual_ends()[episodes])
    losses[episodes, split] = found + config.unusual_end * unusual
    good = (found <= least[episodes] + NEAR_BEST) & ~whole[episodes, split]
    rows = np.concatenate([one, two, episodes[good]])
    first = np.concatenate([np.zeros(len(one) + len(two), int), split[good] + 1])
    every = np.concatenate([losses[one], losses[two], remainders[episodes[good]]])
    return SplitTable(commands(data, rows), jnp.asarray(first), jnp.asarray(every))


@eqx.filter_jit
def _weigh_actions(
    model: Model, command: TokenizedCommand, similarities: Array, scene: SceneArrays
) -> tuple[Array, Array]:
    def one(
        command: TokenizedCommand, similarities: Array, scene: SceneArrays
    ) -> tuple[Array, Array]:
        first, end = jnp.array(0), command.length
        tokens, valid, _ = step_tokens(command, first, end)
        logits = model.language.parse(tokens, valid).action
        _, chosen, reference = choose_step(model, command, similarities, scene.present, first, end)
        simulator = jax.vmap(model.action.simulator, (0, None, None))
        placed = simulator(jnp.eye(len(logits)), scene.before[chosen], scene.before[reference])
        errors = jnp.sum((placed - scene.after[chosen]) ** 2, axis=1)
        return logits, jnp.argmin(errors)

    return jax.vmap(one)(command, similarities, scene)


def weigh_actions(
    model: Model, data: TrainingSet, similarities: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """For one-step commands: the action logits `[R, A]`, and the action that brings the chosen
    object closest to its place in the final scene `[R]`."""
    episodes = data.select(1)
    seen = jnp.asarray(similarities[episodes])
    logits, best = _weigh_actions(model, commands(data, episodes), seen, scenes(data, episodes))
    return np.asarray(logits), np.asarray(best)


class Confirmed(NamedTuple):
    """R steps that the model executes as the final scene shows, and its choices of objects."""

    episode: np.ndarray
    first: np.ndarray
    """First token of the step."""
    end: np.ndarray
    """Token after its last one."""
    objects: np.ndarray
    """Moved object and reference, `[R, 2]`."""


class StepTable(NamedTuple):
    """Confirmed steps, cut out of their commands, and the model's parse of each."""

    tokens: Array
    """Right-padded with row 0, `[T]`."""
    length: Array
    follows: Array
    """Whether it follows another step of its command."""
    meant: Parse
    """Index of the action, and of each argument's group token in the step."""


class ReferenceTable(NamedTuple):
    """Scenes of confirmed steps, their descriptions, and the objects that the model chose."""

    crop_of: Array
    """Indices of the scene's crops, `[M]`."""
    present: Array
    groups: Array
    """Concepts of the descriptions of moved object and reference, `[2, K]`."""
    meant: Array
    """The chosen objects, `[2]`."""


class Decisions(NamedTuple):
    """The decisions about one step of each command: its end, and the probability of
    each decision."""

    end: Array
    split: Array
    action: Array
    object: Array
    reference: Array


@eqx.filter_jit
def _decide(model: Model, command: TokenizedCommand, first: Array) -> Decisions:
    def one(command: TokenizedCommand, first: Array) -> Decisions:
        log_probability = split_log_probability(model.language.splitter, command, first)
        # h_t > 1/2 if ending here is more likely than later.
        rest = jax.lax.cumlogsumexp(log_probability, reverse=True)
        last = jnp.argmax(log_probability > rest + jnp.log(0.5))
        tokens, valid, _ = step_tokens(command, first, last + 1)
        parse = model.language.parse(tokens, valid)
        sure = [jax.nn.softmax(logits).max() for logits in parse]
        return Decisions(last + 1, jnp.exp(log_probability[last]), *sure)

    return jax.vmap(one)(command, first)


def decide(model: Model, data: TrainingSet, episodes: np.ndarray, first: np.ndarray) -> Decisions:
    """Decides the step that begins at token `first` of each command."""
    results = []
    for start in range(0, len(episodes), CHUNK):
        rows = np.arange(start, start + CHUNK).clip(max=len(episodes) - 1)
        found = _decide(model, commands(data, episodes[rows]), jnp.asarray(first[rows]))
        keep = min(CHUNK, len(episodes) - start)
        results.append(jax.tree.map(lambda a, keep=keep: np.asarray(a)[:keep], found))
    return jax.tree.map(lambda *parts: np.concatenate(parts), *results)


def confidences(model: Model, data: TrainingSet) -> np.ndarray:
    """The smallest probability among the decisions about each command, `[N]`."""
    least = np.ones(len(data))
    first, length = np.zeros(len(data), np.int32), data.sentences.length
    for _ in range(MAX_STEPS):
        left = np.flatnonzero(first < length)
        if len(left) == 0:
            break
        step = decide(model, data, left, first[left])
        sure = np.min([step.split, step.action, step.object, step.reference], axis=0)
        least[left] = np.minimum(least[left], sure)
        first[left] = step.end
    return least


def own_choices(
    model: Model, data: TrainingSet, similarities: np.ndarray
) -> tuple[np.ndarray, Choices, np.ndarray]:
    """Episodes with one and two steps that the model splits into steps with two groups each.

    Returns their indices, the choices in each step, and the predicted final locations `[R, M, 5]`.
    """
    episodes, bounds = own_cuts(model, data)
    choices, locations = carry_out(model, data, similarities, episodes, bounds)
    return episodes, choices, locations


def confirmed_steps(
    model: Model, data: TrainingSet, similarities: np.ndarray, config: TrainingConfig
) -> Confirmed:
    """Confirmed steps of commands with one and two steps, all split at the usual end of a step."""
    episodes = np.concatenate([data.select(1), data.select(2)])
    ends, length = data.sentences.usual_ends()[episodes] + 1, data.sentences.length[episodes]
    bounds = np.stack([np.zeros_like(ends), ends, length], axis=1)
    choices, locations = carry_out(model, data, similarities, episodes, bounds)
    losses = np.asarray(_losses(jnp.asarray(locations), scenes(data, episodes), config))
    right = losses <= config.explained
    second = right & (bounds[:, 2] > bounds[:, 1])
    objects = np.stack([choices.object, choices.reference], axis=2)
    return Confirmed(
        np.concatenate([episodes[right], episodes[second]]),
        np.concatenate([bounds[right, 0], bounds[second, 1]]),
        np.concatenate([bounds[right, 1], bounds[second, 2]]),
        np.concatenate([objects[right, 0], objects[second, 1]]),
    )


def _cut_out(data: TrainingSet, steps: Confirmed) -> tuple[Array, Array]:
    """The tokens of the steps, right-padded with row 0, and their lengths."""
    length = steps.end - steps.first
    position = np.arange(roomy(length.max(initial=1)))
    source = np.minimum(steps.first[:, None] + position, data.sentences.tokens.shape[1] - 1)
    tokens = data.sentences.tokens[steps.episode[:, None], source]
    return jnp.asarray(np.where(position < length[:, None], tokens, 0)), jnp.asarray(length)


def own_steps(
    model: Model, data: TrainingSet, similarities: np.ndarray, config: TrainingConfig
) -> StepTable:
    """See `StepTable`."""
    steps = confirmed_steps(model, data, similarities, config)
    tokens, length = _cut_out(data, steps)
    return StepTable(tokens, length, jnp.asarray(steps.first > 0), _meant(model, tokens, length))


def own_references(
    model: Model, data: TrainingSet, similarities: np.ndarray, config: TrainingConfig
) -> ReferenceTable:
    """See `ReferenceTable`."""
    steps = confirmed_steps(model, data, similarities, config)
    tokens, length = _cut_out(data, steps)
    meant = _meant(model, tokens, length)
    at = steps.first[:, None] + np.stack([meant.object, meant.reference], axis=1)
    seen = np.cumsum(data.sentences.tokens[steps.episode] == GROUP_TOKEN, axis=1)
    order = np.take_along_axis(seen, at, axis=1) - 1
    groups = data.sentences.groups[steps.episode[:, None], order]
    return ReferenceTable(
        jnp.asarray(data.crop_of[steps.episode]),
        jnp.asarray(data.present[steps.episode]),
        jnp.asarray(groups),
        jnp.asarray(steps.objects),
    )


@eqx.filter_jit
def _meant(model: Model, tokens: Array, length: Array) -> Parse:
    def one(tokens: Array, length: Array) -> Parse:
        valid = jnp.arange(tokens.shape[0]) < length
        return Parse(*(jnp.argmax(logits) for logits in model.language.parse(tokens, valid)))

    return jax.vmap(one)(tokens, length)


def own_cuts(model: Model, data: TrainingSet) -> tuple[np.ndarray, np.ndarray]:
    """Episodes `[R]` with one and two steps that the model splits into steps with two groups each.

    Also returns the bounds `[R, 3]` of the steps; see `_carry_out`.
    """
    episodes = np.concatenate([data.select(1), data.select(2)])
    end = np.asarray(decide(model, data, episodes, np.zeros(len(episodes), np.int32)).end)
    tokens, length = data.sentences.tokens[episodes], data.sentences.length[episodes]
    inside = np.arange(tokens.shape[1]) < end[:, None]
    groups = ((tokens == GROUP_TOKEN) & inside).sum(axis=1)
    kept = groups == GROUPS_PER_STEP
    count = data.sentences.group_count[episodes]
    kept &= (count == GROUPS_PER_STEP) == (end == length)
    if not kept.any():
        raise NothingPlannedError(
            f"the model splits none of {len(episodes)} commands into steps with two objects each: "
            "train the earlier stages longer, or with more episodes"
        )
    return episodes[kept], np.stack([np.zeros_like(end), end, length], axis=1)[kept]
