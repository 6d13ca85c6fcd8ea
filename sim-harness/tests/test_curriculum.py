"""Training on a toy world: the same seed gives the same weights, interrupted or not; the stages
learn; another domain needs no change."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import equinox as eqx
import jax
import nsrm
import numpy as np
import pytest
from jax.experimental.compilation_cache.compilation_cache import reset_cache
from learn_toys import concatenate, make_toys

from nsrm_harness import domain as domains
from nsrm_harness.evaluation.metrics import WRONG, summarize
from nsrm_harness.learning import decode, naming
from nsrm_harness.learning.checkpoint import CheckpointError, TrainingProgress
from nsrm_harness.learning.config import ConfigError, StageConfig, TrainingConfig, read_config
from nsrm_harness.learning.dataset import TrainingSet
from nsrm_harness.learning.export import (
    ModelFile,
    ModelFileError,
    Thresholds,
    WorkSpace,
    model_bytes,
    read_model,
    write_metrics,
    write_model,
)
from nsrm_harness.learning.model import (
    GROUP_TOKEN,
    Dimensions,
    Model,
    filter_scene,
    tensors,
    unique,
)
from nsrm_harness.learning.nonsense import known_gaps, nonsense
from nsrm_harness.learning.objective import LossWeights
from nsrm_harness.learning.stages import TrainingError
from nsrm_harness.learning.train import TRAINS, Callbacks, Curriculum, Fit, Result, train

BRIEF = StageConfig(epochs=2, learning_rate=1e-3, batch=8)
NONE = dataclasses.replace(BRIEF, epochs=0)
FEW_STEPS = TrainingConfig(
    attempts=1,
    actions=BRIEF,
    # The same code as the first stage, but each stage is compiled anew.
    selection=NONE,
    attributes=NONE,
    splitter=BRIEF,
    joint=BRIEF,
    simulator=BRIEF,
    perception=BRIEF,
    parser=BRIEF,
    # So little training explains no final scene.
    explained=1e9,
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where programs compiled in one test are kept for the others."""
    folder = tmp_path_factory.mktemp("compiled")
    names = ("jax_compilation_cache_dir", "jax_persistent_cache_min_compile_time_secs")
    before = [getattr(jax.config, name) for name in names]
    for name, value in zip(names, (str(folder), 0.2), strict=True):
        jax.config.update(name, value)
    # JAX keeps to the folder with which it first compiled.
    reset_cache()
    yield folder
    for name, value in zip(names, before, strict=True):
        jax.config.update(name, value)
    reset_cache()


@pytest.fixture(scope="module")
def domain() -> domains.Domain:
    return domains.load()


@pytest.fixture(scope="module")
def few(domain: domains.Domain) -> TrainingSet:
    one, two = make_toys(domain, 24, 1, 1, attributes=1), make_toys(domain, 24, 2, 2)
    return concatenate([one.data, two.data])


@pytest.fixture(scope="module")
def whole(domain: domains.Domain, few: TrainingSet, tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("whole")
    return train(Curriculum(domain, few, FEW_STEPS, seed=7), folder, quiet=True)


def same_weights(left: Model, right: Model) -> bool:
    pairs = zip(tensors(left).values(), tensors(right).values(), strict=True)
    return all(np.array_equal(one, other) for one, other in pairs)


def test_an_interrupted_run_ends_with_the_same_weights(
    domain: domains.Domain, few: TrainingSet, whole: Result, tmp_path: Path
) -> None:
    """Broken off in four places, one between stages and one in the last; the same seed gives the
    same result."""
    epochs = 0

    def stop(progress: TrainingProgress) -> None:
        nonlocal epochs
        epochs += 1
        if epochs in (1, 2, 5, 9):
            raise KeyboardInterrupt

    curriculum = Curriculum(domain, few, FEW_STEPS, seed=7)
    for _ in range(4):
        with pytest.raises(KeyboardInterrupt):
            train(curriculum, tmp_path, resume=True, quiet=True, callbacks=Callbacks(stop))
    resumed = train(curriculum, tmp_path, resume=True, quiet=True)
    assert same_weights(resumed.model, whole.model)
    assert resumed.progress.losses == whole.progress.losses
    with pytest.raises(CheckpointError, match="other data, seed or configuration"):
        train(dataclasses.replace(curriculum, seed=8), tmp_path, resume=True, quiet=True)


def test_a_run_does_not_go_on_without_what_its_stage_began_with(
    domain: domains.Domain, few: TrainingSet, tmp_path: Path
) -> None:
    def stop(progress: TrainingProgress) -> None:
        raise KeyboardInterrupt

    curriculum = Curriculum(domain, few, FEW_STEPS, seed=7)
    with pytest.raises(KeyboardInterrupt):
        train(curriculum, tmp_path, quiet=True, callbacks=Callbacks(stop))
    (tmp_path / "begun-0-0.eqx").unlink()
    with pytest.raises(CheckpointError, match=r"begun-0-0\.eqx: missing, so the run cannot resume"):
        train(curriculum, tmp_path, resume=True, quiet=True)


def test_what_is_compiled_for_some_data_serves_other_data(
    domain: domains.Domain, whole: Result, compiled_once: Path, tmp_path: Path
) -> None:
    before = set(compiled_once.glob("jit_step-*-cache"))
    assert before
    one, two = make_toys(domain, 20, 1, 1, attributes=1), make_toys(domain, 20, 2, 2)
    data = concatenate([one.data, two.data])
    train(Curriculum(domain, data, FEW_STEPS, seed=8), tmp_path, quiet=True)
    assert set(compiled_once.glob("jit_step-*-cache")) == before


def test_what_a_stage_does_not_train_stays(
    domain: domains.Domain, few: TrainingSet, whole: Result
) -> None:
    assert not np.allclose(
        whole.model.language.splitter.hazard.weight,
        Model(Dimensions.of(domain), jax.random.key(7)).language.splitter.hazard.weight,
    )
    mean, scale = few.location_statistics()
    np.testing.assert_array_equal(whole.model.action.simulator.location_mean, mean)
    np.testing.assert_array_equal(whole.model.action.simulator.location_scale, scale)
    np.testing.assert_array_equal(whole.model.camera.weight, np.eye(3, 6))


def test_actions_and_objects_are_learned_from_the_outcome_alone(
    domain: domains.Domain, tmp_path: Path
) -> None:
    """The first stage on 500 toys; unseen toys judge it. Chance is a third and a fifth.

    From this seed two actions merge at first, so that the stage is begun again.
    """
    data = make_toys(domain, 500, 1, 5, attributes=1).data
    config = TrainingConfig(
        actions=StageConfig(epochs=14, learning_rate=3e-3, batch=32),
        selection=NONE,
        attributes=NONE,
        splitter=NONE,
        joint=NONE,
        simulator=NONE,
        perception=NONE,
        parser=NONE,
    )
    told: list[tuple[str, int, int]] = []

    def after_stage(name: str, model: Model, progress: TrainingProgress) -> None:
        told.append((name, progress.stage, progress.attempt))

    curriculum = Curriculum(domain, data, config, seed=1)
    callbacks = Callbacks(after_stage=after_stage)
    result = train(curriculum, tmp_path, quiet=True, callbacks=callbacks)
    assert told == [("actions", 1, result.progress.attempt)]
    losses = result.progress.losses["actions"]
    assert losses[-1] < 0.3 * losses[0], f"seed 1: {losses}"
    assert 0 < result.progress.attempt < config.attempts
    assert result.named, f"seed 1: {naming.learned_actions(result.model, domain)}"
    toys = make_toys(domain, 100, 1, 8, attributes=1)
    similarities = decode.see_all(result.model, toys.data)
    bounds = np.stack([np.zeros(100, int), *[toys.data.sentences.length] * 2], axis=1)
    choices, _ = decode.carry_out(result.model, toys.data, similarities, np.arange(100), bounds)
    names = [action.name for action in domain.actions]
    meant = [names.index(program[0].action) for program in toys.programs]
    assert np.mean(choices.action[:, 0] == meant) > 0.95
    assert np.mean(choices.object[:, 0] == toys.objects[:, 0, 0]) > 0.9
    assert np.mean(choices.reference[:, 0] == toys.objects[:, 0, 1]) > 0.9


def test_training_data_without_two_steps_is_refused(domain: domains.Domain, tmp_path: Path) -> None:
    data = make_toys(domain, 8, 1, 1, attributes=1).data
    config = dataclasses.replace(FEW_STEPS, actions=NONE, selection=NONE, attributes=NONE)
    with pytest.raises(TrainingError, match="no two-step commands"):
        train(Curriculum(domain, data, config, seed=0), tmp_path, quiet=True)


def test_a_model_that_carries_out_nothing_is_not_polished(
    domain: domains.Domain, few: TrainingSet
) -> None:
    """A splitter that cuts after every word leaves no step with two objects."""
    model = Model(Dimensions.of(domain), jax.random.key(0))
    hasty = eqx.tree_at(lambda m: m.language.splitter.hazard.bias, model, jax.numpy.full(1, 100.0))
    similarities = decode.see_all(hasty, few)
    with pytest.raises(decode.NothingPlannedError, match="of 48 commands"):
        decode.own_choices(hasty, few, similarities)


def test_only_steps_that_final_scenes_confirm_are_learned_from(
    domain: domains.Domain, few: TrainingSet, whole: Result
) -> None:
    similarities = decode.see_all(whole.model, few)
    every = decode.own_steps(whole.model, few, similarities, FEW_STEPS)
    assert len(every.length) == few.sentences.group_count.sum() // 2
    assert int(every.follows.sum()) == len(few.select(2))
    position = np.arange(every.tokens.shape[1])
    assert (np.asarray(every.tokens)[position >= np.asarray(every.length)[:, None]] == 0).all()
    for argument in every.meant[1:]:
        at = np.asarray(argument)
        assert (np.asarray(every.tokens)[np.arange(len(at)), at] == GROUP_TOKEN).all()
        assert (at < np.asarray(every.length)).all()
    strict = Curriculum(domain, few, dataclasses.replace(FEW_STEPS, explained=0.0), seed=0)
    for stage in ("perception", "parser"):
        with pytest.raises(TrainingError, match="no commands that the model executes correctly"):
            strict.stage(stage, whole.model)


def test_what_is_meant_is_learned_to_be_the_only_match(
    domain: domains.Domain, few: TrainingSet, whole: Result
) -> None:
    similarities = decode.see_all(whole.model, few)
    table = decode.own_references(whole.model, few, similarities, FEW_STEPS)
    spoken = [
        few.sentences.groups[episode, 2 * step : 2 * step + 2]
        for step in range(2)
        for episode in (range(len(few)) if step == 0 else few.select(2))
    ]
    # After so little training both may be the same description of the step.
    for ours, theirs in zip(np.asarray(table.groups), spoken, strict=True):
        assert set(map(tuple, ours)) <= set(map(tuple, theirs))
    assert np.asarray(table.present)[np.arange(len(table.meant))[:, None], table.meant].all()

    def surprise(model: Model) -> float:
        seen = jax.numpy.asarray(decode.see_all(model, few))
        steps = decode.confirmed_steps(whole.model, few, similarities, FEW_STEPS)
        scores = jax.vmap(jax.vmap(filter_scene, (None, 0)))(seen[steps.episode], table.groups)
        alone = jax.vmap(jax.vmap(unique, (0, None)))(scores, table.present)
        meant = np.take_along_axis(np.asarray(alone), np.asarray(table.meant)[..., None], axis=2)
        return float(-meant.mean())

    longer = dataclasses.replace(BRIEF, epochs=20)
    config = dataclasses.replace(FEW_STEPS, perception=longer)
    stage = Curriculum(domain, few, config, seed=0).stage("perception", whole.model)
    fit = Fit(stage, TRAINS["perception"], 0, list(TRAINS).index("perception"))
    state = fit.start(whole.model)
    for epoch in range(longer.epochs):
        state, _ = fit.epoch(state, epoch)
    assert surprise(state.model) < 0.5 * surprise(whole.model)
    trained = {name for name in tensors(whole.model) if name.startswith(TRAINS["perception"])}
    for name in set(tensors(whole.model)) - trained:
        np.testing.assert_array_equal(tensors(state.model)[name], tensors(whole.model)[name], name)


def test_the_last_stage_doubts_nonsense_and_cuts_long_commands(
    domain: domains.Domain, whole: Result
) -> None:
    """Alone, longer: sure of its own steps, in doubt about their words shuffled; and commands of
    three steps are cut, of which there is none in the data."""
    longer = StageConfig(epochs=40, learning_rate=3e-3, batch=32)
    config = dataclasses.replace(FEW_STEPS, parser=longer)
    # The splitter has far more inputs than there are few commands of two steps.
    one, two = make_toys(domain, 24, 1, 1, attributes=1), make_toys(domain, 72, 2, 2)
    more = concatenate([one.data, two.data])
    stage = Curriculum(domain, more, config, seed=0).stage("parser", whole.model)
    fit = Fit(stage, TRAINS["parser"], 0, list(TRAINS).index("parser"))
    state = fit.start(whole.model)
    for epoch in range(longer.epochs):
        state, _ = fit.epoch(state, epoch)
    steps, known = stage.sets[0], known_gaps(more.sentences)
    keys = jax.random.split(jax.random.key(0), len(steps.length))

    @eqx.filter_jit
    def sure(model: Model, said: bool) -> jax.Array:
        def one(key, step):
            tokens, valid = step.tokens, jax.numpy.arange(step.tokens.shape[0]) < step.length
            if not said:
                tokens, valid = nonsense(key, tokens, valid, known, len(domain.vocabulary()))
            return jax.nn.softmax(model.language.parse(tokens, valid).action).max()

        return jax.vmap(one)(keys, steps)

    before = float(np.mean(sure(whole.model, True)) - np.mean(sure(whole.model, False)))
    after = float(np.mean(sure(state.model, True)) - np.mean(sure(state.model, False)))
    assert after > before + 0.1, (before, after)
    long = make_toys(domain, 24, 3, 2).data
    first = np.zeros(24, np.int32)
    for _ in range(2):
        first = np.asarray(decode.decide(state.model, long, np.arange(24), first).end)
    groups = np.cumsum(long.sentences.tokens == GROUP_TOKEN, axis=1)[np.arange(24), first - 1]
    assert np.mean(groups == 4) > 0.9, groups
    frozen = set(tensors(whole.model)) - {
        name for name in tensors(whole.model) if name.startswith(TRAINS["parser"])
    }
    for name in frozen:
        np.testing.assert_array_equal(tensors(state.model)[name], tensors(whole.model)[name], name)


def test_names_follow_the_domains_order(domain: domains.Domain, whole: Result) -> None:
    """Learned actions in another order are put back; the simulator's columns go along."""
    named, _ = naming.name_actions(whole.model, domain)
    counts = naming.learned_actions(named, domain)
    assert np.trace(counts) == max(
        sum(counts[row, column] for row, column in enumerate(order))
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
    )


def test_model_file_is_the_same_for_the_same_model_and_read_back(
    domain: domains.Domain, tmp_path: Path
) -> None:
    model = Model(Dimensions.of(domain), jax.random.key(0))
    space = WorkSpace((0.3, -0.2, 0.0), (0.6, 0.2, 0.2))
    file = ModelFile(model, domain, Thresholds(0.4, 0.6), space, training={"seed": 0})
    path = tmp_path / "model.safetensors"
    write_model(path, file)
    again = read_model(path)
    assert model_bytes(again) == path.read_bytes()
    assert again.thresholds == file.thresholds
    assert again.work_space == space
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    with pytest.raises(ModelFileError, match="hash"):
        read_model(path)


def test_the_core_loads_a_model_none_of_whose_plans_is_right(
    domain: domains.Domain, tmp_path: Path
) -> None:
    model = Model(Dimensions.of(domain), jax.random.key(0))
    space = WorkSpace((0.3, -0.2, 0.0), (0.6, 0.2, 0.2))
    path = tmp_path / "model.safetensors"
    write_model(path, ModelFile(model, domain, Thresholds(0.4, 0.6), space))
    write_metrics(path, summarize([WRONG], Counter({"ambiguous": 1})).as_json())
    loaded = nsrm.Model.load(path).info()["metrics"]
    assert loaded == dict(read_model(path).metrics)
    assert (loaded["program"], loaded["error_median_m"]) == (0.0, None)


def test_a_simulator_without_residual_is_not_exported(domain: domains.Domain) -> None:
    """It says where a block comes to stand, whatever the reference; the core adds that."""
    model = Model(Dimensions.of(domain), jax.random.key(0), residual=False)
    simulator = eqx.tree_at(
        lambda s: (s.output.weight, s.output.bias, s.location_mean),
        model.action.simulator,
        replace_fn=lambda array: 0.0 * array,
    )
    simulator = eqx.tree_at(
        lambda s: s.location_mean, simulator, np.array([0.4, 0.6, 0.2, 0.1, 0.9], np.float32)
    )
    at = np.array([0.1, 0.1, 0.2, 0.2, 1.0], np.float32)
    found = simulator(np.array([1.0, 0.0, 0.0], np.float32), at, at)
    np.testing.assert_allclose(found, [0.3, 0.55, 0.5, 0.65, 0.9], rtol=1e-6)
    space = WorkSpace((0.3, -0.2, 0.0), (0.6, 0.2, 0.2))
    with pytest.raises(ModelFileError, match="no residual"):
        model_bytes(ModelFile(model, domain, Thresholds(0.4, 0.6), space, training={}))


def test_config_file_refuses_what_it_does_not_know(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("temperature = 0.1\n[joint]\nepochs = 3\n")
    config = read_config(path)
    assert (config.temperature, config.joint.epochs) == (0.1, 3)
    assert config.joint.batch == TrainingConfig().joint.batch
    # The rest of a table is that of the very field, whole numbers are numbers.
    path.write_text("[polish_loss]\noverlap = 2\n[parser]\nbatch = 1\n")
    config, default = read_config(path), TrainingConfig()
    assert config == dataclasses.replace(
        default,
        polish_loss=LossWeights(default.polish_loss.square, 2.0),
        parser=dataclasses.replace(default.parser, batch=1),
    )
    assert isinstance(config.polish_loss.overlap, float)
    path.write_text("")
    assert read_config(path) == default
    for text, problem in (
        ("temprature = 0.1", "temprature: unknown key"),
        ("[joint]\nepochs = 1.5", "joint.epochs: should be a valid integer, got 1.5"),
        ("residual = 1", "residual: expected true or false, got 1"),
        ('action_gradient = "soft"', "action_gradient: expected 'exact' or 'gumbel', got 'soft'"),
        ("joint = 3", "joint: expected a table, got 3"),
        ("temperature = -1", "temperature: must be at least 1e-09, got -1"),
        ("temperature = nan", "temperature: should be a finite number, got nan"),
        ("[joint]\nlearning_rate = inf", "joint.learning_rate: should be a finite number, got inf"),
        ("split_samples = 1", "split_samples: must be at least 2, got 1"),
        ("temperature = true", "temperature: should be a valid number, got True"),
        ("temperature = '1'", "temperature: should be a valid number, got '1'"),
        ("[joint]\nepochs = true", "joint.epochs: should be a valid integer, got True"),
        ("[joint]\nepochs = 2.0", "joint.epochs: should be a valid integer, got 2.0"),
        ("[joint]\nbatch = 0", "joint.batch: must be at least 1, got 0"),
        ("[joint]\nepoch = 1", "joint.epoch: unknown key; expected some of: batch, epochs, "),
        ("[loss]\nsquare = -1", "loss.square: must be at least 0, got -1"),
        ("split_gradient = 'best'", "split_gradient: expected 'exact' or 'reinforce', got 'best'"),
    ):
        path.write_text(text)
        with pytest.raises(ConfigError, match=f"^{re.escape(f'{path}: {problem}')}"):
            read_config(path)
