"""Runs the curriculum: the stages in order, with checkpoints and progress.

All random numbers depend on seed, stage and epoch, so an interrupted and resumed run ends with the
same weights.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
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


def untrained(domain: Domain, data: TrainingSet, seed: int, residual: bool = True) -> Model:
    """A random model with the scale of the data's locations."""
    model = Model(Dimensions.of(domain), jax.random.key(seed), residual)
    mean, scale = data.location_statistics()
    return eqx.tree_at(
        lambda m: (m.action.simulator.location_mean, m.action.simulator.location_scale),
        model,
        (jnp.asarray(mean), jnp.asarray(scale)),
    )


def train(
    domain: Domain,
    data: TrainingSet,
    config: TrainingConfig,
    seed: int,
    folder: Path,
    resume: bool = False,
    quiet: bool = False,
    after_epoch: Callable[[TrainingProgress], None] = lambda progress: None,
    after_stage: Callable[[str, Model, TrainingProgress], None] = lambda name, model, progress: (
        None
    ),
) -> Result:
    """Trains from the start, or resumes from the checkpoint in `folder`.

    `KeyboardInterrupt`, also when raised by `after_epoch`, leaves a checkpoint behind. After
    resuming, `after_stage` may be called again for a stage; the progress that it gets is that after
    the stage.
    """
    run = json_text([asdict(config), seed, data.hash(), domain.as_json()])
    checkpoints = Checkpoints(folder, run)
    progress = (checkpoints.progress() if resume else None) or TrainingProgress()
    curriculum = _Curriculum(domain, data, config, seed, checkpoints, progress)
    model, state = curriculum.untrained(), None
    if progress.epoch > 0 or progress.stage > 0:
        state = checkpoints.state(_start(model, progress.stage))
        model = state.model
    names = list(TRAINS)
    while progress.stage < len(names):
        name = names[progress.stage]
        if getattr(config, name).epochs == 0:
            progress.stage += 1
            continue
        model, state = curriculum.carry_out(name, model, state, after_epoch, quiet), None
        if name == "actions" and curriculum.begins_again(model):
            progress.attempt += 1
            progress.epoch = 0
            progress.losses.pop(name, None)
            model = curriculum.untrained()
            continue
        progress.stage, progress.epoch = progress.stage + 1, 0
        after_stage(name, model, progress)
    named, clear = name_actions(model, domain)
    return Result(named, clear, progress)


@dataclass(frozen=True)
class _Curriculum:
    """What all stages of a run have in common; `progress` changes as they are carried out."""

    domain: Domain
    data: TrainingSet
    config: TrainingConfig
    seed: int
    checkpoints: Checkpoints
    progress: TrainingProgress

    @property
    def attempt_seed(self) -> int:
        """Each attempt at the first stage is another random one."""
        return self.seed + NEXT_ATTEMPT * self.progress.attempt

    def untrained(self) -> Model:
        """With what an attempt begins."""
        return untrained(self.domain, self.data, self.attempt_seed, self.config.residual)

    def begins_again(self, model: Model) -> bool:
        """Whether the first stage learned two actions as one and may be tried once more."""
        if self.progress.attempt + 1 >= self.config.attempts:
            return False
        _, clear = name_actions(model, self.domain)
        return not clear

    def carry_out(
        self,
        name: str,
        model: Model,
        state: TrainingState | None,
        after_epoch: Callable[[TrainingProgress], None],
        quiet: bool,
    ) -> Model:
        """The model after a stage; `state`: that in whose middle it was broken off, if it was."""
        progress, checkpoints = self.progress, self.checkpoints
        began = time.monotonic() - progress.seconds.get(name, 0.0)
        if progress.epoch == 0:
            checkpoints.begin(progress, model)
        begun = checkpoints.begun(progress, model)
        stage = make_stage(name, begun, self.data, self.config, self.domain)
        fit = Fit(stage, TRAINS[name], self.attempt_seed, progress.stage)
        state = state or fit.start(model)
        saved = time.monotonic()
        epochs = stage.config.epochs
        with tqdm(total=epochs, initial=progress.epoch, desc=f"{name:>10}", disable=quiet) as bar:
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
                    after_epoch(progress)
            except KeyboardInterrupt:
                checkpoints.save(progress, state)
                raise
        return state.model


def make_stage(
    name: str, model: Model, data: TrainingSet, config: TrainingConfig, domain: Domain
) -> Stage:
    """The stage with this name, made from the model at its start."""
    single = data.select(1, single_attribute=True)
    if name == "actions":
        return stages.one_step_stage(name, config.actions, config, data, single, config.exploration)
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
        order_words = np.isin(domain.vocabulary(), domain.grammar.order_words)
        return stages.parser_stage(config, data, table, order_words)
    episodes, choices, _ = decode.own_choices(model, data, similarities)
    return stages.simulator_stage(config, data, episodes, choices)


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
        trained = eqx.filter(model, trainable(model, self._trains))
        return TrainingState(model, OPTIMIZER.init(trained))

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
            self._step = _compiled(self._stage, structure, fixed_structure, rest)
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


def _compiled(
    stage: Stage, structure: Any, fixed_structure: Any, rest: Any
) -> Callable[..., tuple[list[Array], Array]]:
    """One optimiser step: maps the leaves of the trained tensors and their moments to new ones and
    the loss.

    * `structure`: structure of the trained tensors and their moments
    * `fixed_structure`: structure of the other tensors; `rest`: the model without tensors
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
        kept = eqx.combine(jax.tree.unflatten(fixed_structure, fixed), rest)
        drawn = jax.random.fold_in(key, number)

        def loss(trained: Any) -> Array:
            return stage.loss(eqx.combine(trained, kept), shared, batch, drawn, done)

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


def _start(model: Model, stage: int) -> TrainingState:
    """A state with the structure of the stage's state."""
    trains = list(TRAINS.values())[stage]
    trained = eqx.filter(model, trainable(model, trains))
    return TrainingState(model, OPTIMIZER.init(trained))
