"""Defines the stages of the curriculum (section IV-F): episodes, loss, trained parts.

A stage is made from the model at its start, also if a run is resumed in its middle, so that what it
precomputes (cosines, a table of losses, hard choices) is the same again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.learning import decode
from nsrm_harness.learning.augmentation import varied_crops
from nsrm_harness.learning.config import REINFORCE, StageConfig, TrainingConfig
from nsrm_harness.learning.dataset import TrainingSet, doubled, roomy
from nsrm_harness.learning.decode import Choices, ReferenceTable, SplitTable, StepTable
from nsrm_harness.learning.fillers import fillers, with_fillers
from nsrm_harness.learning.losses import (
    Demonstration,
    Said,
    TwoSteps,
    end_loss,
    misuse_loss,
    nonsense_loss,
    one_step_loss,
    reordered_loss,
    two_step_loss,
)
from nsrm_harness.learning.misuse import habits
from nsrm_harness.learning.model import Model, filter_scene, unique
from nsrm_harness.learning.nonsense import known_gaps
from nsrm_harness.learning.objective import (
    SceneArrays,
    entropy,
    location_loss,
    move,
    reinforce,
    soft_minimum,
)
from nsrm_harness.learning.splits import (
    TokenizedCommand,
    split_log_probability,
)

PARSER = (
    "language.embedding",
    "language.encoder",
    "language.action_decoder",
    "language.object_decoder",
    "language.reference_decoder",
)
PERCEPTION = ("vision",)
PERCEPTION_AND_PARSER = PERCEPTION + PARSER
SIMULATOR = ("action.simulator.input", "action.simulator.hidden", "action.simulator.output")
SPLITTER = ("language.splitter",)
FURTHER = ("language.acceptability", "language.relation_decoder")
"""What the paper's parser does not have."""


class TrainingError(HarnessError):
    """A training run that cannot start, or whose result cannot be used."""


Loss = Callable[[Any, Any, tuple[Any, ...], Array, Array], Array]
LOSSES = 16
"""Number of configurations for which the loss of a stage is kept."""


class Stage(NamedTuple):
    """Everything the trainer needs to run a stage.

    The data is in `sets` and `shared`, and the loss contains none of it. It is the same function
    for all runs with the same configuration, and compiled once for all data with the same shapes.
    """

    name: str
    config: StageConfig
    sets: tuple[Any, ...]
    """Trees of arrays; a batch takes the same number of rows of each."""
    shared: Any
    """Arrays that every batch needs."""
    loss: Loss
    """Maps model, `shared`, a batch of each set, a key and the finished share of the stage to the
    batch's mean loss."""


class Lookup(NamedTuple):
    """Data that all demonstrations share."""

    crops: Array
    """All crops `[B, 3, 32, 32]`, followed by black ones; see `lookup`."""
    known: Array
    """Hashes of the words before descriptions; see `nonsense`."""


def lookup(data: TrainingSet) -> Lookup:
    """The shared data of a training set; the number of crops is `doubled`."""
    crops = jnp.asarray(data.crops)
    room = doubled(len(crops)) - len(crops)
    return Lookup(jnp.pad(crops, ((0, room), (0, 0), (0, 0), (0, 0))), known_gaps(data.sentences))


def demonstrations(data: TrainingSet, chosen: np.ndarray) -> Demonstration:
    """The chosen episodes as one tree with a leading axis; commands are padded to the longest."""
    tokens, length, groups, count = decode.commands(data, chosen)
    width = roomy(int(length.max()))
    command = TokenizedCommand(tokens[:, :width], length, groups[:, : count.max()], count)
    crop_of = jnp.asarray(data.crop_of[chosen])
    usual_end = jnp.asarray(data.sentences.usual_ends()[chosen])
    return Demonstration(command, decode.scenes(data, chosen), crop_of, usual_end)


def see(model: Model, crops: Array, crop_of: Array, key: Array) -> Array:
    """Cosines of each object with each concept: indices `[N, M]` -> `[N, M, C]`."""
    seen = varied_crops(key, crops[crop_of.reshape(-1)])
    embeddings = jax.vmap(model.vision.encode)(*seen)
    similarities = jax.vmap(model.vision.similarities)(embeddings)
    return similarities.reshape(*crop_of.shape, -1)


def one_step_stage(
    name: str,
    stage: StageConfig,
    config: TrainingConfig,
    data: TrainingSet,
    chosen: np.ndarray,
    exploration: float | None,
) -> Stage:
    """(a) and (b): one-step commands; see `one_step_loss`.

    `exploration` decays to zero in the first half of the stage.
    """
    _some(chosen, f"{name}: no one-step commands")
    loss = _one_step(config, exploration)
    return Stage(name, stage, (demonstrations(data, chosen),), lookup(data), loss)


@lru_cache(LOSSES)
def _one_step(config: TrainingConfig, exploration: float | None) -> Loss:
    def loss(
        model: Model, lookup: Lookup, batch: tuple[Any, ...], key: Array, done: Array
    ) -> Array:
        (demonstration,) = batch
        looking, choosing = jax.random.split(key)
        similarities = see(model, lookup.crops, demonstration.crop_of, looking)
        keys = jax.random.split(choosing, len(similarities))
        explore = None
        if exploration is not None:
            explore = exploration * jnp.maximum(1.0 - 2.0 * done, 0.0)

        def one(key: Array, demonstration: Demonstration, similarities: Array) -> Array:
            choosing, saying = jax.random.split(key)
            loss = one_step_loss(choosing, model, demonstration, similarities, config, explore)
            if exploration:
                # First it must discover the actions.
                return loss
            command = demonstration.command
            heap = nonsense_loss(saying, model, command.tokens, command.length, lookup.known)
            return loss + config.nonsense * heap

        return jax.vmap(one)(keys, demonstration, similarities).mean()

    return loss


def splitter_stage(config: TrainingConfig, table: SplitTable) -> Stage:
    """(c): the splitter on a table of losses of whole commands and of their remainders."""
    return Stage("splitter", config.splitter, (table,), (), _splitter(config))


@lru_cache(LOSSES)
def _splitter(config: TrainingConfig) -> Loss:
    def loss(model: Model, _: Any, batch: tuple[Any, ...], key: Array, done: Array) -> Array:
        table: SplitTable = batch[0]

        def one(key: Array, command: TokenizedCommand, first: Array, losses: Array) -> Array:
            log_probability = split_log_probability(model.language.splitter, command, first)
            if config.split_gradient == REINFORCE:
                spread = config.split_spread * jnp.maximum(1.0 - 2.0 * done, 0.0)
                samples = config.split_samples
                loss = reinforce(key, log_probability, losses.__getitem__, samples, spread)
            else:
                loss = soft_minimum(log_probability, losses, config.temperature)
            # First what is possible, then what is preferred: otherwise it would
            # settle on splits that
            # are impossible for some commands.
            return loss + done * config.indecision * entropy(log_probability)

        keys = jax.random.split(key, len(table.first))
        return jax.vmap(one)(keys, *table).mean()

    return loss


def joint_stage(config: TrainingConfig, data: TrainingSet) -> Stage:
    """(d): everything at once, with as many one-step as two-step commands in a batch."""
    one, two = data.select(1), data.select(2)
    _some(one, "joint: no one-step commands")
    _some(two, "joint: no two-step commands")
    sets = (demonstrations(data, one), demonstrations(data, two))
    loss = _joint(config, data.sentences.longest_step())
    return Stage("joint", config.joint, sets, lookup(data), loss)


@lru_cache(LOSSES)
def _joint(config: TrainingConfig, width: int) -> Loss:
    def loss(
        model: Model, lookup: Lookup, batch: tuple[Any, ...], key: Array, done: Array
    ) -> Array:
        single, double = batch
        known = lookup.known
        half = len(single.crop_of)
        looking, choosing = jax.random.split(key)
        crop_of = jnp.concatenate([single.crop_of, double.crop_of])
        similarities = see(model, lookup.crops, crop_of, looking)
        keys = jax.random.split(choosing, 2 * half)

        def one(key: Array, demonstration: Demonstration, similarities: Array) -> Array:
            choosing, saying = jax.random.split(key)
            loss = one_step_loss(choosing, model, demonstration, similarities, config)
            command = demonstration.command
            heap = nonsense_loss(saying, model, command.tokens, command.length, known)
            loss += config.nonsense * heap
            # Any split of a one-step command fails: only the whole counts.
            whole = split_log_probability(model.language.splitter, command, jnp.array(0))
            return loss - config.temperature * whole[command.length - 1]

        def two(key: Array, demonstration: Demonstration, similarities: Array) -> Array:
            steps = TwoSteps(model, demonstration, similarities, config, width)
            return two_step_loss(key, steps, known)

        first = jax.vmap(one)(keys[:half], single, similarities[:half])
        second = jax.vmap(two)(keys[half:], double, similarities[half:])
        return (first.mean() + second.mean()) / 2

    return loss


def simulator_stage(
    config: TrainingConfig, data: TrainingSet, chosen: np.ndarray, choices: Choices
) -> Stage:
    """(e): the simulator on the model's own choices, rolled out."""
    _some(chosen, "simulator: no commands that the model can execute")
    scenes = demonstrations(data, chosen).scene
    return Stage("simulator", config.simulator, ((scenes, choices),), (), _simulator(config))


@lru_cache(LOSSES)
def _simulator(config: TrainingConfig) -> Loss:
    def rollout(model: Model, scene: SceneArrays, choices: Choices) -> Array:
        simulator = model.action.simulator
        locations = scene.before
        for step in range(choices.action.shape[0]):
            action = jax.nn.one_hot(choices.action[step], simulator.input.weight.shape[1] - 10)
            hots = [
                jax.nn.one_hot(index[step], len(locations))
                for index in (choices.object, choices.reference)
            ]
            moved = move(simulator, action, hots[0], hots[1], locations)
            locations = jnp.where(step < choices.count, moved, locations)
        losses = location_loss(locations, scene.after, config.polish_loss)
        losses = jnp.minimum(losses, config.polish_cap)
        return jnp.sum(jnp.where(scene.present, losses, 0.0)) / jnp.sum(scene.present)

    def loss(model: Model, _: Any, batch: tuple[Any, ...], key: Array, done: Array) -> Array:
        return jax.vmap(rollout, (None, 0, 0))(model, *batch[0]).mean()

    return loss


def perception_stage(config: TrainingConfig, data: TrainingSet, table: ReferenceTable) -> Stage:
    """(f): only perception, on the descriptions of confirmed steps: the mean surprise, in nats,
    that the intended object matches and no other in the scene does."""
    _some(np.asarray(table.meant), "perception: no commands that the model executes correctly")
    return Stage("perception", config.perception, (table,), lookup(data), _perception_loss)


def _perception_loss(
    model: Model, lookup: Lookup, batch: tuple[Any, ...], key: Array, done: Array
) -> Array:
    table: ReferenceTable = batch[0]
    similarities = see(model, lookup.crops, table.crop_of, key)

    def surprise(similarities: Array, present: Array, groups: Array, meant: Array) -> Array:
        scores = jax.vmap(filter_scene, (None, 0))(similarities, groups)
        alone = jax.vmap(unique, (0, None))(scores, present)
        return -alone[jnp.arange(len(meant)), meant].mean()

    return jax.vmap(surprise)(similarities, table.present, table.groups, table.meant).mean()


def parser_stage(
    config: TrainingConfig, data: TrainingSet, table: StepTable, order_words: np.ndarray
) -> Stage:
    """(g): parser and splitter on steps whose meaning the final scene has confirmed.

    Both are trained on them with inserted fillers, the parser also on nonsense and misuse, the
    splitter on commands combined from these steps. `order_words`: bool `[V]`, from the domain.
    """
    _some(np.asarray(table.length), "parser: no commands that the model executes correctly")
    found = habits(table, fillers(table, order_words), jnp.asarray(order_words))
    said = Said(found, known_gaps(data.sentences))
    following = jax.tree.map(lambda column: column[np.asarray(table.follows)], table)
    _some(
        np.asarray(following.length),
        "parser: no two-step commands that the model executes correctly",
    )

    return Stage("parser", config.parser, (table, following), said, _parser(config))


@lru_cache(LOSSES)
def _parser(config: TrainingConfig) -> Loss:
    def loss(model: Model, said: Said, batch: tuple[Any, ...], key: Array, done: Array) -> Array:
        steps, following = batch
        others = jax.tree.map(lambda column: jnp.roll(column, 1, axis=0), steps)

        def one(key: Array, step: StepTable, following: StepTable, other: StepTable) -> Array:
            filling, saying, joining, misusing, reordering = jax.random.split(key, 5)
            heap = nonsense_loss(saying, model, step.tokens, step.length, said.known)
            heap += misuse_loss(misusing, model, step, other, said)
            splitter = model.language.splitter
            heap += reordered_loss(reordering, splitter, step, other, said.habits)
            filled = with_fillers(filling, step, said.habits.fillers)
            valid = jnp.arange(filled.tokens.shape[0]) < filled.length
            parse = model.language.parse(filled.tokens, valid)
            meaning = sum(
                -jax.nn.log_softmax(logits)[meant]
                for logits, meant in zip(parse, filled.meant, strict=True)
            )
            end = end_loss(joining, splitter, filled, following)
            return meaning + end + config.nonsense_parser * heap

        keys = jax.random.split(key, len(steps.length))
        return jax.vmap(one)(keys, steps, following, others).mean()

    return loss


def _some(chosen: np.ndarray, problem: str) -> None:
    if len(chosen) == 0:
        raise TrainingError(f"{problem} in the training data: generate more episodes")
