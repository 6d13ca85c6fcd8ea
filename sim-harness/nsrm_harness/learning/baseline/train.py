"""Trains the baseline on the final scenes alone, as in `learning`, in three stages.

Nothing is discrete: attention blends, so the loss (section IV-E) is differentiable. But a blend of
all objects explains no scene, and from there some seeds never learn. So it starts like `learning`:
with one-step commands and the soft minimum over all pairs of objects.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from tqdm import tqdm

from nsrm_harness.learning import decode
from nsrm_harness.learning.augmentation import varied_crops
from nsrm_harness.learning.baseline.model import Baseline, Meaning, carry_out
from nsrm_harness.learning.baseline.words import StepWords
from nsrm_harness.learning.config import StageConfig
from nsrm_harness.learning.dataset import TrainingSet
from nsrm_harness.learning.objective import (
    Grounding,
    LossWeights,
    Objective,
    SceneArrays,
    exact_step,
    location_loss,
    scene_loss,
)
from nsrm_harness.learning.stages import Lookup, Stage, TrainingError, lookup
from nsrm_harness.learning.train import NEXT_ATTEMPT, Fit

PARTS = (
    "embedding",
    "encoder",
    "action_decoder",
    "color",
    "brightness",
    "object_pointer",
    "reference_pointer",
)
SIMULATOR = ("simulator.input", "simulator.hidden", "simulator.output")
CHUNK = 256
"""Number of episodes per batch."""
LEAST_SHARE = 1e-9
"""Smallest attention for the logarithm."""


@dataclass(frozen=True)
class BaselineConfig:
    """Everything that a training run depends on, except data and seed."""

    loss: LossWeights = field(default_factory=lambda: LossWeights(square=200.0, overlap=1.0))
    polish_loss: LossWeights = field(default_factory=lambda: LossWeights(5000.0, 1.0))
    """Loss weights of the last stage."""
    polish_cap: float = 3.0
    """Largest loss of one object there; see `learning.config`."""
    temperature: float = 0.05
    """τ of the soft minimum in the first stage."""
    single: StageConfig = field(default_factory=lambda: StageConfig(30, 3e-3, batch=32))
    """One-step commands, over all pairs of objects."""
    joint: StageConfig = field(default_factory=lambda: StageConfig(40, 1e-3, batch=32))
    """One-step and two-step commands, on blends."""
    attempts: int = 3
    """Largest number of attempts: some starts memorise combinations of words and objects, and are
    slow to unlearn them."""
    learned: float = 0.1
    """Loss of the joint stage's last epoch below which no further attempt is needed."""
    simulator: StageConfig = field(default_factory=lambda: StageConfig(600, 5e-3, batch=256))
    """Only the action module, on the model's own attention."""


class Sample(NamedTuple):
    """One demonstration: steps `[S, T]`, `[S]`, their number, scene, and its crops `[M]`."""

    tokens: Array
    length: Array
    count: Array
    scene: SceneArrays
    crop_of: Array


SampleLoss = Callable[[Baseline, Sample, Array, BaselineConfig], Array]
"""Loss of one sample, from object embeddings `[M, 64]`."""


def samples(data: TrainingSet, words: StepWords, chosen: np.ndarray) -> Sample:
    """The chosen episodes with a leading axis, and as many steps as they have."""
    steps = int(words.count[chosen].max(initial=1))
    return Sample(
        jnp.asarray(words.tokens[chosen, :steps]),
        jnp.asarray(words.length[chosen, :steps]),
        jnp.asarray(words.count[chosen]),
        decode.scenes(data, chosen),
        jnp.asarray(data.crop_of[chosen]),
    )


def untrained(words: tuple[str, ...], data: TrainingSet, seed: int) -> Baseline:
    """A random model with the scale of the data's locations."""
    mean, scale = data.location_statistics()
    return eqx.tree_at(
        lambda m: (m.simulator.location_mean, m.simulator.location_scale),
        Baseline(words, jax.random.key(seed)),
        (jnp.asarray(mean), jnp.asarray(scale)),
    )


def pairs_loss(model: Baseline, sample: Sample, objects: Array, config: BaselineConfig) -> Array:
    """Soft minimum over both arguments of a one-step command; object embeddings `[M, 64]`."""
    scene = sample.scene
    meaning = model.understand(sample.tokens, sample.length, objects, scene.present)
    action, *attention = (one[0] for one in meaning)
    chosen, reference = (jnp.log(jnp.maximum(share, LEAST_SHARE)) for share in attention)

    def simulate(_: Array, *arguments: Array) -> Array:
        return model.simulator(action, *arguments)

    only_action = Grounding(jnp.zeros(1), chosen, reference)
    objective = Objective(config.loss, config.temperature)
    return exact_step(simulate, only_action, scene, objective)


def blends_loss(model: Baseline, sample: Sample, objects: Array, config: BaselineConfig) -> Array:
    """Loss of the final scene that attention predicts; object embeddings `[M, 64]`."""
    scene = sample.scene
    meaning = model.understand(sample.tokens, sample.length, objects, scene.present)
    locations, _ = carry_out(model.simulator, meaning, scene.before, sample.count)
    return scene_loss(locations, scene, config.loss)


def attention_stage(
    name: str,
    stage: StageConfig,
    config: BaselineConfig,
    sample: Sample,
    lookup: Lookup,
    sample_loss: SampleLoss,
) -> Stage:
    """A stage that trains everything, on augmented crops."""

    def loss(
        model: Baseline, lookup: Lookup, batch: tuple[Any, ...], key: Array, done: Array
    ) -> Array:
        sample: Sample = batch[0]
        seen = varied_crops(key, lookup.crops[sample.crop_of.reshape(-1)])
        objects = jax.vmap(model.encode)(*seen).reshape(*sample.crop_of.shape, -1)
        losses = jax.vmap(sample_loss, (None, 0, 0, None))
        return losses(model, sample, objects, config).mean()

    return Stage(name, stage, (sample,), lookup, loss)


def simulator_stage(config: BaselineConfig, sample: Sample, meaning: Meaning) -> Stage:
    """A stage that trains the action module on the rest of the model's output."""

    def rollout(model: Baseline, sample: Sample, meaning: Meaning) -> Array:
        scene = sample.scene
        locations, _ = carry_out(model.simulator, meaning, scene.before, sample.count)
        losses = location_loss(locations, scene.after, config.polish_loss)
        losses = jnp.minimum(losses, config.polish_cap)
        return jnp.sum(jnp.where(scene.present, losses, 0.0)) / jnp.sum(scene.present)

    def loss(model: Baseline, _: Any, batch: tuple[Any, ...], key: Array, done: Array) -> Array:
        return jax.vmap(rollout, (None, 0, 0))(model, *batch[0]).mean()

    return Stage("simulator", config.simulator, ((sample, meaning),), (), loss)


@eqx.filter_jit
def _understand(model: Baseline, sample: Sample, crops: Array) -> Meaning:
    def one(sample: Sample, crops: Array) -> Meaning:
        objects = jax.vmap(model.encode)(crops)
        return model.understand(sample.tokens, sample.length, objects, sample.scene.present)

    return jax.vmap(one)(sample, crops)


def understand(model: Baseline, data: TrainingSet, words: StepWords) -> Meaning:
    """The model's meaning of every command, with a leading axis."""
    parts = []
    for start in range(0, len(data), CHUNK):
        # Always the same size, so that it is compiled once.
        chosen = np.arange(start, start + CHUNK).clip(max=len(data) - 1)
        sample = samples(data, words, chosen)
        found = _understand(model, sample, jnp.asarray(data.crops[data.crop_of[chosen]]))
        keep = min(CHUNK, len(data) - start)
        parts.append(jax.tree.map(lambda a, keep=keep: a[:keep], found))
    return jax.tree.map(lambda *arrays: jnp.concatenate(arrays), *parts)


def train(
    vocabulary: tuple[str, ...],
    data: TrainingSet,
    words: StepWords,
    config: BaselineConfig,
    seed: int,
    quiet: bool = False,
) -> Baseline:
    """Trains from the start; the same seed gives the same weights."""
    single = np.flatnonzero(words.count == 1)
    if len(single) == 0:
        raise TrainingError(
            "baseline: no one-step commands in the training data: generate more episodes"
        )
    first, every = (samples(data, words, chosen) for chosen in (single, np.arange(len(data))))
    common, attempts = lookup(data), []
    attention = (
        attention_stage("single", config.single, config, first, common, pairs_loss),
        attention_stage("joint", config.joint, config, every, common, blends_loss),
    )
    for attempt in range(config.attempts):
        drawn, loss = seed + NEXT_ATTEMPT * attempt, np.inf
        model = untrained(vocabulary, data, drawn)
        for number, stage in enumerate(attention):
            model, loss = _fit(stage, PARTS + SIMULATOR, model, drawn, number, quiet)
        attempts.append((loss, model))
        if loss < config.learned:
            break
    _, model = min(attempts, key=lambda attempt: attempt[0])
    stage = simulator_stage(config, every, understand(model, data, words))
    return _fit(stage, SIMULATOR, model, seed, len(attention), quiet)[0]


def _fit(
    stage: Stage,
    trains: tuple[str, ...],
    model: Baseline,
    seed: int,
    number: int,
    quiet: bool,
) -> tuple[Baseline, float]:
    """Trains one stage; also returns the mean loss of the last epoch."""
    fit = Fit(stage, trains, seed, number)
    state, loss = fit.start(model), np.inf
    with tqdm(total=stage.config.epochs, desc=f"{stage.name:>10}", disable=quiet) as bar:
        for epoch in range(stage.config.epochs):
            state, loss = fit.epoch(state, epoch)
            if not np.isfinite(loss):
                raise TrainingError(f"baseline: {stage.name}: the loss is not finite: {loss}")
            bar.set_postfix(loss=f"{loss:.5f}", refresh=False)
            bar.update()
    return state.model, loss
