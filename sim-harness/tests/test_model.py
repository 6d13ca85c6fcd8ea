"""The network: shapes, padding, and agreement with Equinox's own cells."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.domain.program import SUPERLATIVES
from nsrm_harness.learning import model as network
from nsrm_harness.learning.model import (
    Conv,
    Dimensions,
    Model,
    center_size,
    corners,
    filter_scene,
    run_gru,
    unique,
)

DOMAIN = domains.load()

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Dimensions.of(DOMAIN), jax.random.key(3))


def test_tensors_have_the_names_and_shapes_of_the_model_file(model: Model) -> None:
    shapes = {name: array.shape for name, array in network.tensors(model).items()}
    words, actions, concepts = len(DOMAIN.vocabulary()), len(DOMAIN.actions), len(DOMAIN.concepts)
    assert shapes["language.embedding.weight"] == (words, 32)
    assert shapes["language.encoder.backward.weight_hh"] == (144, 48)
    assert shapes["language.action_decoder.weight"] == (actions, 96)
    assert shapes["language.relation_decoder.weight"] == (2 * (actions + len(SUPERLATIVES)), 96)
    assert shapes["language.acceptability.hidden.weight"] == (16, 96)
    assert shapes["language.splitter.hidden.weight"] == (32, 176)
    assert shapes["vision.color.patch.weight"] == (24, 3, 4, 4)
    assert shapes["vision.brightness.dense.weight"] == (32, 512)
    assert shapes["vision.operator.size.output.weight"] == (16, 32)
    assert shapes["vision.concept.weight"] == (concepts, 16)
    assert shapes["action.simulator.input.weight"] == (64, actions + 10)
    assert shapes["camera.weight"] == (3, 6)
    assert len(shapes) == 60


def test_gru_is_equinox_own() -> None:
    cell = eqx.nn.GRUCell(5, 7, key=jax.random.key(0))
    inputs = jax.random.normal(jax.random.key(1), (6, 5))
    hidden = jnp.zeros(7)
    expected = []
    for row in inputs:
        hidden = cell(row, hidden)
        expected.append(hidden)
    found = run_gru(cell, inputs, jnp.ones(6, bool))
    np.testing.assert_allclose(found, jnp.stack(expected), atol=1e-6)


def test_convolution_is_a_cross_correlation() -> None:
    conv = Conv(2, 3, 4, jax.random.key(0))
    image = jax.random.normal(jax.random.key(1), (2, 12, 8))[:, :8, :8]
    expected = jax.lax.conv(image[None], conv.weight, (4, 4), "VALID")[0]
    np.testing.assert_allclose(conv(image), expected, atol=1e-5)


def test_padding_has_no_influence(model: Model) -> None:
    rows = jnp.array([4, 0, 7, 9, 0, 2])
    padded = jnp.concatenate([rows, jnp.array([0, 5, 8])])
    valid = jnp.arange(9) < 6
    exact = model.language.heard(rows, jnp.ones(6, bool))
    found = model.language.heard(padded, valid)
    for left, right in zip((*exact.parse, exact.roles), (*found.parse, found.roles), strict=True):
        np.testing.assert_allclose(left, right[: len(left)], atol=1e-5)
    np.testing.assert_allclose(exact.acceptable, found.acceptable, atol=1e-5)
    hazards = model.language.splitter(rows, jnp.ones(6, bool))
    np.testing.assert_allclose(hazards, model.language.splitter(padded, valid)[:6], atol=1e-5)


def test_a_step_is_as_acceptable_as_all_its_words(model: Model) -> None:
    rows, every = jnp.array([4, 0, 7, 9, 0, 2]), jnp.ones(6, bool)
    # Until it is taught otherwise, every word is acceptable.
    assert float(model.language.heard(rows, every).acceptable) > -1e-6
    judge = network.Acceptability(jax.random.key(1), odds=1.0)
    weight = jax.random.normal(jax.random.key(2), (1, 16))
    judge = eqx.tree_at(lambda judge: judge.output.weight, judge, weight)
    doubting = eqx.tree_at(lambda model: model.language.acceptability, model, judge)
    states, _ = model.language.encoder(model.language.embedding.weight[rows], every)
    expected = 0.0
    for state in states:
        (odds,) = judge.output(jnp.tanh(judge.hidden(state)))
        expected += float(jax.nn.log_sigmoid(odds))
    np.testing.assert_allclose(doubting.language.heard(rows, every).acceptable, expected, rtol=1e-5)


def test_a_model_that_was_not_taught_relations_finds_none(model: Model) -> None:
    rows = jnp.array([4, 0, 7, 9, 0, 2])
    roles = jax.nn.softmax(model.language.heard(rows, jnp.ones(6, bool)).roles)
    relations = model.language.action_decoder.weight.shape[0] + len(SUPERLATIVES)
    assert roles.shape == (6, 1 + 2 * relations)
    assert float(roles[:, 0].min()) > 1.0 - 1e-6


def test_backward_state_starts_at_the_last_word(model: Model) -> None:
    words = model.language.embedding.weight[jnp.array([3, 1, 4])]
    states, instruction = model.language.encoder(words, jnp.ones(3, bool))
    alone = model.language.encoder.backward(words[2], jnp.zeros(48))
    np.testing.assert_allclose(states[2, 48:], alone, atol=1e-6)
    np.testing.assert_allclose(instruction, jnp.concatenate([states[2, :48], states[0, 48:]]))


def test_size_sees_no_color(model: Model) -> None:
    crop = jax.random.uniform(jax.random.key(0), (3, 32, 32))
    same_brightness = jnp.broadcast_to(crop.max(axis=0), (3, 32, 32))
    similarities = [
        model.vision.similarities(model.vision.encode(picture))
        for picture in (crop, same_brightness)
    ]
    np.testing.assert_allclose(similarities[0][7:], similarities[1][7:], atol=1e-5)
    assert float(jnp.abs(similarities[0][:7] - similarities[1][:7]).max()) > 1e-3


def test_filter_takes_the_least_and_none_is_the_whole_scene() -> None:
    similarities = jnp.array([[0.9, -0.2], [0.4, 0.5]])
    np.testing.assert_allclose(filter_scene(similarities, jnp.array([0, 1])), [-0.2, 0.4])
    np.testing.assert_allclose(filter_scene(similarities, jnp.array([0, -1])), [0.9, 0.4])
    np.testing.assert_allclose(filter_scene(similarities, jnp.array([-1, -1])), [1.0, 1.0])


def test_unique_is_the_only_match() -> None:
    scores, present = jnp.array([0.5, 0.9, 1.0]), jnp.array([True, True, False])
    matches = 1 / (1 + np.exp(-10 * (np.array([0.5, 0.9]) - 0.5)))
    only = [matches[0] * (1 - matches[1]), matches[1] * (1 - matches[0]), 0.0]
    np.testing.assert_allclose(jnp.exp(unique(scores, present)), only, rtol=1e-5)
    # Given that one matches, the softmax of ten times the scores.
    given = jnp.exp(jax.nn.log_softmax(unique(scores, present)))
    np.testing.assert_allclose(given[:2], jax.nn.softmax(10 * scores[:2]), rtol=1e-5)


def test_corners_undo_center_size() -> None:
    location = jnp.array([0.1, 0.2, 0.4, 0.3, 1.5])
    np.testing.assert_allclose(center_size(location), [0.25, 0.25, 0.3, 0.1, 1.5], atol=1e-6)
    np.testing.assert_allclose(corners(center_size(location)), location, atol=1e-6)


def test_simulator_without_change_keeps_the_size_at_the_references_centre(model: Model) -> None:
    simulator = eqx.tree_at(
        lambda s: (s.output.weight, s.output.bias),
        model.action.simulator,
        (jnp.zeros((5, 64)), jnp.zeros(5)),
    )
    moved = jnp.array([0.1, 0.1, 0.2, 0.3, 1.0])
    beside = jnp.array([0.5, 0.5, 0.9, 0.7, 1.4])
    found = simulator(jnp.array([1.0, 0.0, 0.0]), moved, beside)
    np.testing.assert_allclose(found, [0.65, 0.5, 0.75, 0.7, 1.4], atol=1e-6)
