"""The baseline: splits at given ends, attention that sums to one, learning from outcomes alone."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array
from learn_toys import Toys, make_toys

from nsrm_harness import domain as domains
from nsrm_harness.domain.grammar import Grammar, Style
from nsrm_harness.domain.tokens import UnknownWordError, split
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.learning.baseline.evaluate import plans
from nsrm_harness.learning.baseline.file import BaselineFile, read_baseline, write_baseline
from nsrm_harness.learning.baseline.model import ACTION, Baseline, carry_out
from nsrm_harness.learning.baseline.train import (
    PARTS,
    SIMULATOR,
    BaselineConfig,
    attention_stage,
    blends_loss,
    pairs_loss,
    samples,
    train,
    understand,
)
from nsrm_harness.learning.baseline.words import StepWords, parts, vocabulary
from nsrm_harness.learning.config import StageConfig
from nsrm_harness.learning.export import (
    SCHEMA,
    ModelFile,
    ModelFileError,
    Thresholds,
    WorkSpace,
    write_model,
)
from nsrm_harness.learning.model import Dimensions, Model, tensors
from nsrm_harness.learning.objective import scene_loss
from nsrm_harness.learning.stages import Stage, TrainingError, lookup
from nsrm_harness.learning.train import NEXT_ATTEMPT, trainable

DOMAIN = domains.load()
WORDS = vocabulary(DOMAIN)
NONE = StageConfig(epochs=0, learning_rate=1e-3, batch=8)

pytestmark = pytest.mark.slow


def said(toys: Toys, seed: int) -> StepWords:
    """Sentences for the toys' programs, cut where their steps end."""
    rng, grammar = np.random.default_rng(seed), Grammar(DOMAIN, Style())
    sentences = [grammar.sentence(rng, program) for program in toys.programs]
    return StepWords.of(WORDS, [s.text for s in sentences], [s.ends for s in sentences])


@pytest.fixture(scope="module")
def toys() -> Toys:
    return make_toys(DOMAIN, 12, 2, 1)


@pytest.fixture(scope="module")
def words(toys: Toys) -> StepWords:
    return said(toys, 1)


def test_sentences_are_cut_where_steps_end() -> None:
    sentence = "Put the red block on the blue one, then put the lego above it all."
    first = sentence.index(", then")
    assert parts(sentence, [first, len(sentence)]) == [sentence[:first], sentence[first:]]
    short = "put the red block on the blue block"
    joined = f"{short}, then {short}"
    cut = StepWords.of(WORDS, [short, joined], [[len(short)], [len(short), len(joined)]])
    assert cut.count.tolist() == [1, 2]
    assert cut.length.tolist() == [[8, 0], [8, 10]]
    np.testing.assert_array_equal(cut.tokens[0, 0], cut.tokens[1, 0])
    assert [WORDS[row] for row in cut.tokens[1, 1, :10]] == split(f", then {short}")
    assert not cut.tokens[1, 1, 10:].any()
    assert not cut.tokens[0, 1].any()
    with pytest.raises(UnknownWordError, match="'purple'"):
        StepWords.of(WORDS, ["put the purple block"], [[20]])


def test_attribute_words_are_words_and_no_group_is() -> None:
    assert {"red", "lego"} <= set(WORDS)
    assert domains.GROUP_TOKEN not in WORDS
    assert len(set(WORDS)) == len(WORDS)


def test_shapes_and_attention(toys: Toys, words: StepWords) -> None:
    data = dataclasses.replace(toys.data, present=toys.data.present.copy())
    data.present[3, 4] = False
    meaning = understand(Baseline(WORDS, jax.random.key(0)), data, words)
    assert meaning.action.shape == (12, 2, ACTION)
    for attention in (meaning.object, meaning.reference):
        assert attention.shape == (12, 2, 5)
        np.testing.assert_allclose(np.sum(attention, axis=-1), 1.0, atol=1e-5)
        assert np.all(attention[3, :, 4] == 0.0)
    assert not np.allclose(meaning.object, meaning.reference, atol=1e-4)


def test_padding_has_no_influence(toys: Toys, words: StepWords) -> None:
    model = Baseline(WORDS, jax.random.key(0))
    wider = dataclasses.replace(
        words, tokens=np.pad(words.tokens, ((0, 0), (0, 0), (0, 5)), constant_values=7)
    )
    for left, right in zip(
        understand(model, toys.data, words), understand(model, toys.data, wider), strict=True
    ):
        np.testing.assert_allclose(left, right, atol=1e-5)


def test_steps_follow_one_another(toys: Toys, words: StepWords) -> None:
    """Hard: the greatest attention moves, the others stay, the next step sees the new scene."""
    model, before = Baseline(WORDS, jax.random.key(0)), jnp.asarray(toys.data.before[0])
    meaning = jax.tree.map(lambda a: a[0], understand(model, toys.data, words))
    end, goals = carry_out(model.simulator, meaning, before, jnp.array(2), hard=True)
    moved = np.argmax(meaning.object, axis=-1)
    scene = before
    for step in range(2):
        blends = [attention[step] @ scene for attention in meaning[1:]]
        goal = model.simulator(meaning.action[step], *blends)
        np.testing.assert_allclose(goals[step], goal, atol=1e-5)
        scene = scene.at[moved[step]].set(goal)
    np.testing.assert_allclose(end, scene, atol=1e-5)
    first, _ = carry_out(model.simulator, meaning, before, jnp.array(1), hard=True)
    rest = np.delete(np.arange(5), moved[0])
    np.testing.assert_array_equal(first[rest], before[rest])
    np.testing.assert_allclose(first[moved[0]], goals[0], atol=1e-6)
    soft, _ = carry_out(model.simulator, meaning, before, jnp.array(1))
    shares = meaning.object[0][:, None]
    np.testing.assert_allclose(soft, before + shares * (goals[0] - before), atol=1e-5)


def test_the_first_stage_weighs_every_pair(toys: Toys, words: StepWords) -> None:
    """Its loss by hand: each pair moves one object, and counts as far as it is attended to."""
    model, config = Baseline(WORDS, jax.random.key(0)), BaselineConfig()
    sample = jax.tree.map(lambda a: a[0], samples(toys.data, words, np.arange(1)))
    meaning = jax.tree.map(lambda a: a[0, 0], understand(model, toys.data, words))
    before = sample.scene.before

    @jax.jit
    def pair_loss(moved: int, reference: int) -> Array:
        goal = model.simulator(meaning.action, before[moved], before[reference])
        return scene_loss(before.at[moved].set(goal), sample.scene, config.loss)

    pairs = list(itertools.product(range(5), range(5)))
    losses = np.array([pair_loss(*pair) for pair in pairs], np.float64)
    shares = np.array([meaning.object[i] * meaning.reference[j] for i, j in pairs], np.float64)
    expected = -config.temperature * np.log(np.sum(shares * np.exp(-losses / config.temperature)))
    crops = jnp.asarray(toys.data.crops[toys.data.crop_of[0]])
    found = eqx.filter_jit(lambda m: pairs_loss(m, sample, jax.vmap(m.encode)(crops), config))
    assert float(found(model)) == pytest.approx(expected, rel=1e-4)


def test_the_loss_reaches_every_part(toys: Toys, words: StepWords) -> None:
    model, every = Baseline(WORDS, jax.random.key(0)), samples(toys.data, words, np.arange(12))
    common, key = lookup(toys.data), jax.random.key(1)
    stage = attention_stage("joint", NONE, BaselineConfig(), every, common, blends_loss)
    gradient = eqx.filter_jit(
        eqx.filter_grad(lambda m: stage.loss(m, stage.shared, stage.sets, key, jnp.array(0)))
    )(model)
    trained = eqx.filter(model, trainable(model, PARTS + SIMULATOR))
    names = set(tensors(trained))
    assert names == {
        name for name in tensors(model) if not name.startswith(("camera", "simulator.location"))
    }
    for name, array in tensors(gradient).items():
        assert bool(np.any(array)) == (name in names), name


def test_learns_from_the_outcome_alone() -> None:
    """One-step toys of one attribute; unseen toys judge it. Chance is a fifth."""
    toys, config = make_toys(DOMAIN, 500, 1, 5, attributes=1), BaselineConfig()
    config = dataclasses.replace(
        config,
        single=dataclasses.replace(config.single, epochs=20),
        joint=NONE,
        attempts=1,
        simulator=dataclasses.replace(config.simulator, epochs=20),
    )
    model = train(WORDS, toys.data, said(toys, 5), config, 0, quiet=True)
    unseen = make_toys(DOMAIN, 100, 1, 8, attributes=1)
    planned = plans(model, unseen.data, said(unseen, 8), [default_camera()] * 100)
    chosen = np.array([(p[0].object_id - 1, p[0].reference_id - 1) for p in planned])
    right = np.mean(chosen == unseen.objects[:, 0], axis=0)
    assert np.all(right > 0.6), f"seed 0: {right}"


@pytest.mark.parametrize(
    ("joint_losses", "kept"),
    [([0.05], 0), ([0.3, 0.05], 1), ([0.3, 0.2, 0.4], 1)],
)
def test_it_begins_again_until_it_has_learned(
    monkeypatch: pytest.MonkeyPatch, joint_losses: list[float], kept: int
) -> None:
    """And of attempts that all failed it keeps the one with the least loss."""
    one, ran = make_toys(DOMAIN, 12, 1, 2), []
    losses = iter([*(loss for joint in joint_losses for loss in (0.04, joint)), 0.1])

    def fit(
        stage: Stage, _: tuple[str, ...], model: Baseline, *rest: Any
    ) -> tuple[Baseline, float]:
        ran.append((stage.name, rest[0]))
        return model, next(losses)

    monkeypatch.setattr("nsrm_harness.learning.baseline.train._fit", fit)
    model = train(WORDS, one.data, said(one, 2), BaselineConfig(), 3, quiet=True)
    seeds = [3 + NEXT_ATTEMPT * attempt for attempt in range(len(joint_losses))]
    begun = [(name, seed) for seed in seeds for name in ("single", "joint")]
    assert ran == [*begun, ("simulator", 3)]
    expected = Baseline(WORDS, jax.random.key(seeds[kept]))
    np.testing.assert_array_equal(model.embedding.weight, expected.embedding.weight)


def test_its_file_is_read_back(tmp_path: Path) -> None:
    path, model = tmp_path / "new" / "baseline.safetensors", Baseline(WORDS, jax.random.key(3))
    write_baseline(path, BaselineFile(model, DOMAIN, {"seed": 3}, {"program": None}))
    read = read_baseline(path)
    for name, array in tensors(model).items():
        np.testing.assert_array_equal(array, tensors(read.model)[name], name)
    assert read.model.words == WORDS
    assert (read.training, read.metrics) == ({"seed": 3}, {"program": None})
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_what_is_no_baseline_is_refused(toys: Toys, words: StepWords, tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    model = Model(Dimensions.of(DOMAIN), jax.random.key(0))
    space = WorkSpace((0, 0, 0), (1, 1, 1))
    write_model(path, ModelFile(model, DOMAIN, Thresholds(0.4, 0.6), space))
    with pytest.raises(ModelFileError, match=f"schema baseline 2, got {SCHEMA}: train again"):
        read_baseline(path)
    with pytest.raises(TrainingError, match="no one-step commands"):
        train(WORDS, toys.data, words, BaselineConfig(), 0, quiet=True)
