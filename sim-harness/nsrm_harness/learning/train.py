"""Runs the curriculum: the stages in order, with checkpoints and progress.

All random numbers depend on seed, stage and epoch, so an interrupted and resumed run ends with the
same weights.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jax import Array
from tqdm import tqdm

from nsrm_harness.common.json_text import json_text
from nsrm_harness.domain import Domain
from nsrm_harness.learning import decode, stages
from nsrm_harness.learning.checkpoint import Checkpoints, TrainingProgress
from nsrm_harness.learning.config import TrainingConfig
from nsrm_harness.learning.dataset import TrainingSet
from nsrm_harness.learning.model import Dimensions, Model
from nsrm_harness.learning.naming import name_actions
from nsrm_harness.learning.stages import (
    PARSER,
    PERCEPTION,
    PERCEPTION_AND_PARSER,
    SIMULATOR,
    SPLITTER,
    Loss,
    Stage,
)

TRAINS = {
    "actions": PERCEPTION_AND_PARSER + SIMULATOR,
    "selection": PERCEPTION_AND_PARSER + SIMULATOR,
    "attributes": PERCEPTION_AND_PARSER,
    "splitter": SPLITTER,
    "joint": PERCEPTION_AND_PARSER + SIMULATOR + SPLITTER,
    "simulator": SIMULATOR,
    "perception": PERCEPTION,
    "parser": PARSER + SPLITTER,
}
"""The stages in order, with the name prefixes of the tensors that each trains."""
FINAL_RATE = 0.05
"""Final learning rate of a stage, relative to the initial one."""
GRADIENT_NORM = 1.0
"""Gradients are clipped to this norm."""
OPTIMIZER = optax.chain(optax.clip_by_global_norm(GRADIENT_NORM), optax.scale_by_adam())
"""Adam on clipped gradients; the learning rate decays along a cosine over a stage."""
SECONDS_A_CHECKPOINT = 5.0
STEPS = 16
"""Number of optimiser steps that are kept, each compiled for a loss and a model."""
NEXT_ATTEMPT = 1_000_003
"""Added to the seed for each further attempt."""


class TrainingState(NamedTuple):
    """The state that changes during a stage."""

    model: Any
    """`Model`, or another network with the same parts."""
    optimizer: optax.OptState


class Result(NamedTuple):
    """A trained model, and details of its training."""

    model: Model
    named: bool
    """Whether each action was learned separately; see `naming`."""
    progress: TrainingProgress


@dataclass(frozen=True)
class Callbacks:
    """Functions that are called during a training."""

    after_epoch: Callable[[TrainingProgress], None] = lambda progress: None
    """If it raises `KeyboardInterrupt`, the training stops with a checkpoint."""
    after_stage: Callable[[str, Model, TrainingProgress], None] = lambda name, model, progress: None
    """Gets the name of the stage, and model and progress after it. After resuming, it may be called
    again for a stage."""


NO_CALLBACKS = Callbacks()


@dataclass(frozen=True)
class Curriculum:
    """Everything that the weights depend on."""

    domain: Domain
    data: TrainingSet
    config: TrainingConfig
    seed: int

    def identity(self) -> str:
        """A text that differs if anything here differs; a checkpoint records it."""
        return json_text([asdict(self.config), self.seed, self.data.hash(), self.domain.as_json()])

    def attempt_seed(self, attempt: int) -> int:
        """The seed of an attempt at the first stage; each starts with other random weights."""
        return self.seed + NEXT_ATTEMPT * attempt

    def untrained(self, attempt: int = 0) -> Model:
        """A random model with the scale of the data's locations."""
        key = jax.random.key(self.attempt_seed(attempt))
        model = Model(Dimensions.of(self.domain), key, self.config.residual)
        mean, scale = self.data.location_statistics()
        return eqx.tree_at(
            lambda m: (m.action.simulator.location_mean, m.action.simulator.location_scale),
            model,
            (jnp.asarray(mean), jnp.asarray(scale)),
        )

    def stage(self, name: str, model: Model) -> Stage:
        """The stage with this name, made from the model at its start."""
        data, config = self.data, self.config
        single = data.select(1, single_attribute=True)
        if name == "actions":
            stage, exploration = config.actions, config.exploration
            return stages.one_step_stage(name, stage, config, data, single, exploration)
        if name == "selection":
            return stages.one_step_stage(name, config.selection, config, data, single, None)
        if name == "attributes":
            every = data.select(1)
            return stages.one_step_stage(name, config.attributes, config, data, every, 0.0)
        if name == "joint":
            return stages.joint_stage(config, data)
        if len(data.select(2)) == 0:
            raise stages.TrainingError(
                f"{name}: no two-step commands in the training data: generate more episodes"
            )
        similarities = decode.see_all(model, data)
        if name == "splitter":
            table = decode.split_table(model, data, similarities, config)
            return stages.splitter_stage(config, table)
        if name == "perception":
            references = decode.own_references(model, data, similarities, config)
            return stages.perception_stage(config, data, references)
        if name == "parser":
            table = decode.own_steps(model, data, similarities, config)
            order_words = np.isin(self.domain.vocabulary(), self.domain.grammar.order_words)
            return stages.parser_stage(config, data, table, order_words)
        episodes, choices, _ = decode.own_choices(model, data, similarities)
        return stages.simulator_stage(config, data, episodes, choices)


def train(
    curriculum: Curriculum,
    folder: Path,
    resume: bool = False,
    quiet: bool = False,
    callbacks: Callbacks = NO_CALLBACKS,
) -> Result:
    """Trains from the start, or resumes from the checkpoint in `folder`.

    `KeyboardInterrupt` leaves a checkpoint behind.
    """
    checkpoints = Checkpoints(folder, curriculum.identity())
    progress = (checkpoints.progress() if resume else None) or TrainingProgress()
    trainer = _Trainer(curriculum, checkpoints, progress, callbacks, quiet)
    model, state = curriculum.untrained(progress.attempt), None
    names = list(TRAINS)
    if progress.epoch > 0 or progress.stage > 0:
        state = checkpoints.state(_start(model, TRAINS[names[progress.stage]]))
        model = state.model
    while progress.stage < len(names):
        name = names[progress.stage]
        if getattr(curriculum.config, name).epochs == 0:
            progress.stage += 1
            continue
        model, state = trainer.train_stage(name, model, state), None
        if name == "actions" and trainer.needs_another_attempt(model):
            progress.attempt += 1
            progress.epoch = 0
            progress.losses.pop(name, None)
            model = curriculum.untrained(progress.attempt)
            continue
        progress.stage, progress.epoch = progress.stage + 1, 0
        callbacks.after_stage(name, model, progress)
    named, clear = name_actions(model, curriculum.domain)
    return Result(named, clear, progress)


@dataclass(frozen=True)
class _Trainer:
    """Trains the stages of a curriculum one by one, and keeps `progress` up to date."""

    curriculum: Curriculum
    checkpoints: Checkpoints
    progress: TrainingProgress
    callbacks: Callbacks
    quiet: bool

    def needs_another_attempt(self, model: Model) -> bool:
        """Whether the first stage learned two actions as one, and attempts are left."""
        if self.progress.attempt + 1 >= self.curriculum.config.attempts:
            return False
        _, clear = name_actions(model, self.curriculum.domain)
        return not clear

    def train_stage(self, name: str, model: Model, state: TrainingState | None) -> Model:
        """The model after a stage; `state`: where the stage was interrupted, if it was."""
        progress, checkpoints = self.progress, self.checkpoints
        began = time.monotonic() - progress.seconds.get(name, 0.0)
        if progress.epoch == 0:
            checkpoints.begin(progress, model)
        begun = checkpoints.begun(progress, model)
        stage = self.curriculum.stage(name, begun)
        seed = self.curriculum.attempt_seed(progress.attempt)
        fit = Fit(stage, TRAINS[name], seed, progress.stage)
        state = state or fit.start(model)
        saved = time.monotonic()
        epochs, initial = stage.config.epochs, progress.epoch
        with tqdm(total=epochs, initial=initial, desc=f"{name:>10}", disable=self.quiet) as bar:
            try:
                while progress.epoch < epochs:
                    state, loss = fit.epoch(state, progress.epoch)
                    if not np.isfinite(loss):
                        raise stages.TrainingError(f"{name}: the loss is not finite: {loss}")
                    progress.epoch += 1
                    progress.seconds[name] = time.monotonic() - began
                    progress.losses.setdefault(name, []).append(loss)
                    bar.set_postfix(loss=f"{loss:.5f}", refresh=False)
                    bar.update()
                    if time.monotonic() - saved > SECONDS_A_CHECKPOINT:
                        checkpoints.save(progress, state)
                        saved = time.monotonic()
                    self.callbacks.after_epoch(progress)
            except KeyboardInterrupt:
                checkpoints.save(progress, state)
                raise
        return state.model


class Fit:
    """The optimisation of one stage."""

    def __init__(self, stage: Stage, trains: tuple[str, ...], seed: int, number: int):
        self._stage, self._trains, self._seed, self._number = stage, trains, seed, number
        sizes = [len(jax.tree.leaves(one)[0]) for one in stage.sets]
        # A batch has the same number of rows of each set; smaller sets are repeated.
        self._share = min(max(stage.config.batch // len(sizes), 1), *sizes, max(sizes))
        self._sizes = sizes
        self._batches = max(sizes) // self._share
        steps = max(stage.config.epochs * self._batches, 1)
        self._rate = optax.cosine_decay_schedule(stage.config.learning_rate, steps, FINAL_RATE)
        self._step: Callable[..., tuple[list[Array], Array]] | None = None

    def start(self, model: eqx.Module) -> TrainingState:
        """The state before the first epoch."""
        return _start(model, self._trains)

    def epoch(self, state: TrainingState, epoch: int) -> tuple[TrainingState, float]:
        """Runs one epoch; also returns the mean loss."""
        rng = np.random.default_rng([self._seed, self._number, epoch])
        key = jax.random.fold_in(jax.random.key(self._seed), self._number * 100_000 + epoch)
        taken = self._batches * self._share
        rows = [
            np.resize(rng.permutation(size), taken).reshape(self._batches, self._share)
            for size in self._sizes
        ]
        done = np.float32(epoch / self._stage.config.epochs)
        rates = np.asarray(self._rate(epoch * self._batches + jnp.arange(self._batches)))
        trained, kept = eqx.partition(state.model, trainable(state.model, self._trains))
        fixed, rest = eqx.partition(kept, eqx.is_array)
        # As lists: flattening a model at each step would take longer than some steps.
        changing, structure = jax.tree.flatten((trained, state.optimizer))
        fixed, fixed_structure = jax.tree.flatten(fixed)
        if self._step is None:
            # Leaves without numbers, functions for instance.
            others, rest_structure = jax.tree.flatten(rest)
            self._step = _compiled(
                self._stage.loss, structure, fixed_structure, tuple(others), rest_structure
            )
        losses = []
        for number in range(self._batches):
            batch = _take(self._stage.sets, tuple(row[number] for row in rows))
            changing, loss = self._step(
                changing, fixed, self._stage.shared, batch, key, number, done, rates[number]
            )
            losses.append(loss)
        trained, optimizer = jax.tree.unflatten(structure, changing)
        state = TrainingState(eqx.combine(trained, kept), optimizer)
        return state, float(np.mean(jax.device_get(losses)))


@lru_cache(STEPS)
def _compiled(
    loss_of: Loss, structure: Any, fixed_structure: Any, others: tuple[Any, ...], rest: Any
) -> Callable[..., tuple[list[Array], Array]]:
    """One optimiser step: maps the leaves of the trained tensors and their moments to new ones and
    the loss. It is traced and compiled once for all runs of a process.

    * `structure`: structure of the trained tensors and their moments
    * `fixed_structure`: structure of the other tensors
    * `others`, `rest`: leaves and structure of the model without tensors
    """

    @jax.jit
    def step(
        changing: list[Array],
        fixed: list[Array],
        shared: Any,
        batch: tuple[Any, ...],
        key: Array,
        number: Array,
        done: Array,
        rate: Array,
    ) -> tuple[list[Array], Array]:
        trained, moments = jax.tree.unflatten(structure, changing)
        kept = eqx.combine(
            jax.tree.unflatten(fixed_structure, fixed), jax.tree.unflatten(rest, others)
        )
        drawn = jax.random.fold_in(key, number)

        def loss(trained: Any) -> Array:
            return loss_of(eqx.combine(trained, kept), shared, batch, drawn, done)

        value, gradient = jax.value_and_grad(loss)(trained)
        directions, moments = OPTIMIZER.update(gradient, moments, trained)
        updates = jax.tree.map(lambda direction: -rate * direction, directions)
        return jax.tree.leaves((eqx.apply_updates(trained, updates), moments)), value

    return step


@jax.jit
def _take(sets: tuple[Any, ...], rows: tuple[Array, ...]) -> tuple[Any, ...]:
    return tuple(
        jax.tree.map(lambda a, at=at: a[at], one) for one, at in zip(sets, rows, strict=True)
    )


def trainable(model: eqx.Module, trains: tuple[str, ...]) -> Any:
    """The model's tree with true for the arrays whose names start with one of `trains`."""

    def is_trained(path: Any, leaf: Any) -> bool:
        name = jax.tree_util.keystr(path, simple=True, separator=".")
        return eqx.is_array(leaf) and name.startswith(trains)

    return jax.tree_util.tree_map_with_path(is_trained, model)


def _start(model: eqx.Module, trains: tuple[str, ...]) -> TrainingState:
    """The state before the first epoch of a stage that trains the tensors with these prefixes."""
    trained = eqx.filter(model, trainable(model, trains))
    return TrainingState(model, OPTIMIZER.init(trained))
