"""Defines the stages of the curriculum (section IV-F): episodes, loss, trained parts.

A stage is made from the model at its start, also if a run is resumed in its middle, so that what it
precomputes (cosines, a table of losses, hard choices) is the same again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.learning import decode
from nsrm_harness.learning.config import REINFORCE, StageConfig, TrainingConfig
from nsrm_harness.learning.dataset import GROUPS_PER_STEP, TrainingSet, doubled, roomy
from nsrm_harness.learning.decode import Choices, ReferenceTable, SplitTable, StepTable
from nsrm_harness.learning.fillers import fillers, with_fillers
from nsrm_harness.learning.misuse import Habits, habits, misuse
from nsrm_harness.learning.model import GROUP_TOKEN, MISSING, Model, Splitter, filter_scene, unique
from nsrm_harness.learning.nonsense import is_reserved, known_gaps, nonsense
from nsrm_harness.learning.objective import (
    Grounding,
    SceneArrays,
    entropy,
    exact_step,
    ground,
    location_loss,
    move,
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
SHIFT = 2
"""Largest shift of a crop in training; pixels of 32."""
NOISE = 0.02
"""Standard deviation of the noise on a crop, for values in 0..1."""
SAME_NOISE = 8
"""Number of crops in a batch that share noise, which is the slowest part of `varied`."""
TINT = 0.5
"""Largest scaling of the channels for the brightness; natural logarithm."""


class TrainingError(HarnessError):
    """A training run that cannot start, or whose result cannot be used."""


class Demonstration(NamedTuple):
    """One demonstration: its command, its scene, the indices of its crops `[M]`, and the usual end
    of its first step."""

    command: TokenizedCommand
    scene: SceneArrays
    crop_of: Array
    usual_end: Array


class Stage(NamedTuple):
    """Everything the trainer needs to run a stage.

    The data is in `sets` and `shared`, and the loss contains none of it: it is compiled once for
    all data with the same shapes.
    """

    name: str
    config: StageConfig
    sets: tuple[Any, ...]
    """Trees of arrays; a batch takes the same number of rows of each."""
    shared: Any
    """Arrays that every batch needs."""
    loss: Callable[[Any, Any, tuple[Any, ...], Array, Array], Array]
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


def varied(key: Array, crop: Array, noise: Array) -> tuple[Array, Array]:
    """Augments a crop `[3, 32, 32]`: mirrored or not, shifted by up to `SHIFT` pixels, with noise;
    also returns its tint.

    Without this, a few thousand crops are soon memorised. The tint (see `encode_views`) keeps
    colour out of the features for shapes: how much a block's brightness differs from the table's
    depends on its colour.
    """
    mirror, shift, tint = jax.random.split(key, 3)
    crop = jnp.where(jax.random.bernoulli(mirror), crop[:, :, ::-1], crop)
    row, column = jax.random.randint(shift, (2,), 0, 2 * SHIFT + 1)
    wide = jnp.pad(crop, ((0, 0), (SHIFT, SHIFT), (SHIFT, SHIFT)), mode="edge")
    moved = jax.lax.dynamic_slice(wide, (0, row, column), crop.shape)
    tints = jnp.exp(jax.random.uniform(tint, (3, 1, 1), minval=-TINT, maxval=TINT))
    return moved + NOISE * noise, tints


def varied_crops(key: Array, crops: Array) -> tuple[Array, Array]:
    """A batch of augmented crops `[N, 3, 32, 32]`, and their tints."""
    varying, noise = jax.random.split(key)
    fields = jax.random.normal(noise, (-(-len(crops) // SAME_NOISE), *crops.shape[1:]))
    fields = jnp.tile(fields, (SAME_NOISE, 1, 1, 1))[: len(crops)]
    return jax.vmap(varied)(jax.random.split(varying, len(crops)), crops, fields)


def see(model: Model, crops: Array, crop_of: Array, key: Array) -> Array:
    """Cosines of each object with each concept: indices `[N, M]` -> `[N, M, C]`."""
    seen = varied_crops(key, crops[crop_of.reshape(-1)])
    embeddings = jax.vmap(model.vision.encode)(*seen)
    similarities = jax.vmap(model.vision.similarities)(embeddings)
    return similarities.reshape(*crop_of.shape, -1)


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

    return Stage(name, stage, (demonstrations(data, chosen),), lookup(data), loss)


def splitter_stage(config: TrainingConfig, table: SplitTable) -> Stage:
    """(c): the splitter on a table of losses of whole commands and of their remainders."""

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

    return Stage("splitter", config.splitter, (table,), (), loss)


def joint_stage(config: TrainingConfig, data: TrainingSet) -> Stage:
    """(d): everything at once, with as many one-step as two-step commands in a batch."""
    one, two = data.select(1), data.select(2)
    _some(one, "joint: no one-step commands")
    _some(two, "joint: no two-step commands")
    width = data.sentences.longest_step()

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

    sets = (demonstrations(data, one), demonstrations(data, two))
    return Stage("joint", config.joint, sets, lookup(data), loss)


def simulator_stage(
    config: TrainingConfig, data: TrainingSet, chosen: np.ndarray, choices: Choices
) -> Stage:
    """(e): the simulator on the model's own choices, rolled out."""
    _some(chosen, "simulator: no commands that the model can execute")
    scenes = demonstrations(data, chosen).scene

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

    return Stage("simulator", config.simulator, ((scenes, choices),), (), loss)


def perception_stage(config: TrainingConfig, data: TrainingSet, table: ReferenceTable) -> Stage:
    """(f): only perception, on the descriptions of confirmed steps: the mean surprise, in nats,
    that the intended object matches and no other in the scene does."""
    _some(np.asarray(table.meant), "perception: no commands that the model executes correctly")

    def loss(
        model: Model, lookup: Lookup, batch: tuple[Any, ...], key: Array, done: Array
    ) -> Array:
        table: ReferenceTable = batch[0]
        similarities = see(model, lookup.crops, table.crop_of, key)

        def surprise(similarities: Array, present: Array, groups: Array, meant: Array) -> Array:
            scores = jax.vmap(filter_scene, (None, 0))(similarities, groups)
            alone = jax.vmap(unique, (0, None))(scores, present)
            return -alone[jnp.arange(len(meant)), meant].mean()

        return jax.vmap(surprise)(similarities, table.present, table.groups, table.meant).mean()

    return Stage("perception", config.perception, (table,), lookup(data), loss)


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


class Said(NamedTuple):
    """Data about the words of all steps."""

    habits: Habits
    known: Array
    """Hashes of the words before descriptions; see `nonsense`."""


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

    return Stage("parser", config.parser, (table, following), said, loss)


def _some(chosen: np.ndarray, problem: str) -> None:
    if len(chosen) == 0:
        raise TrainingError(f"{problem} in the training data: generate more episodes")
