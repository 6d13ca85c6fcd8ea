"""The loss and its treatment of discrete choices."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.learning.dataset import Sentences
from nsrm_harness.learning.decode import StepTable
from nsrm_harness.learning.losses import end_loss
from nsrm_harness.learning.model import Dimensions, Model, Parse
from nsrm_harness.learning.nonsense import known_gaps, nonsense
from nsrm_harness.learning.objective import (
    Grounding,
    LossWeights,
    Objective,
    SceneArrays,
    entropy,
    exact_step,
    ground,
    intersection_over_union,
    location_loss,
    move,
    reinforce,
    sampled_steps,
    scene_loss,
    soft_minimum,
    straight_through,
)
from nsrm_harness.learning.splits import (
    TokenizedCommand,
    end_log_probability,
    split_log_probability,
    step_tokens,
)

WEIGHTS = LossWeights(square=200.0, overlap=1.0)
OBJECTIVE = Objective(WEIGHTS, temperature=0.05)
MODEL = Model(Dimensions.of(domains.load()), jax.random.key(0))

pytestmark = pytest.mark.slow


def test_intersection_over_union_by_hand() -> None:
    left = jnp.array([0.0, 0.0, 0.2, 0.2])
    np.testing.assert_allclose(intersection_over_union(left, left), 1.0, atol=1e-6)
    half = jnp.array([0.1, 0.0, 0.3, 0.2])
    np.testing.assert_allclose(intersection_over_union(left, half), 1 / 3, atol=1e-6)
    assert float(intersection_over_union(left, left + 0.5)) == 0.0


def test_location_loss_by_hand() -> None:
    target = jnp.array([0.0, 0.0, 0.2, 0.2, 1.0])
    predicted = jnp.array([0.1, 0.0, 0.3, 0.2, 1.1])
    expected = 200.0 * (3 * 0.01) / 5 + (1 - 1 / 3)
    np.testing.assert_allclose(location_loss(predicted, target, WEIGHTS), expected, rtol=1e-5)


def test_soft_minimum_lies_between_least_and_mean() -> None:
    log_probability = jnp.log(jnp.array([0.2, 0.3, 0.5]))
    losses = jnp.array([0.1, 0.5, 0.9])
    cold = float(soft_minimum(log_probability, losses, 1e-3))
    hot = float(soft_minimum(log_probability, losses, 1e3))
    np.testing.assert_allclose(cold, 0.1 - 1e-3 * np.log(0.2), atol=1e-5)
    np.testing.assert_allclose(hot, 0.62, atol=1e-3)


def test_soft_minimum_credits_the_choice_that_explains() -> None:
    losses = jnp.array([0.02, 0.4, 0.4])
    gradient = jax.grad(lambda logits: soft_minimum(jax.nn.log_softmax(logits), losses, 0.05))(
        jnp.zeros(3)
    )
    assert gradient[0] < 0 < gradient[1]


def test_reinforce_has_the_gradient_of_the_expectation() -> None:
    logits, scale = jnp.array([0.3, -0.2, 0.9]), jnp.array(1.5)
    losses = jnp.array([0.1, 0.7, 0.4])

    def expected(logits: jax.Array, scale: jax.Array) -> jax.Array:
        return jnp.sum(jax.nn.softmax(logits) * scale * losses)

    def sampled(logits: jax.Array, scale: jax.Array, key: jax.Array) -> jax.Array:
        log_probability = jax.nn.log_softmax(logits)
        return reinforce(key, log_probability, lambda at: scale * losses[at], 2, 0.0)

    keys = jax.random.split(jax.random.key(0), 40_000)
    gradients = jax.vmap(jax.grad(sampled, (0, 1)), (None, None, 0))(logits, scale, keys)
    for found, exact in zip(gradients, jax.grad(expected, (0, 1))(logits, scale), strict=True):
        error = found.std(axis=0) / np.sqrt(len(keys))
        assert np.all(np.abs(found.mean(axis=0) - exact) < 5 * error)
    # Equal losses leave the entropy alone: it pulls towards the even distribution.
    flat = jax.grad(
        lambda x: reinforce(keys[0], jax.nn.log_softmax(x), lambda at: 0.0 * losses[at], 2, 1.0)
    )(logits)
    assert flat[1] < 0 < flat[2]


def test_exact_step_is_the_sum_over_every_choice() -> None:
    """Against a loop over actions, objects and references, with a missing object."""
    rng = np.random.default_rng(1)
    low = rng.uniform(0.1, 0.5, (4, 2))
    before = np.concatenate([low, low + 0.1, rng.uniform(1, 1.2, (4, 1))], axis=1)
    present = np.array([True, True, True, False])
    scene = SceneArrays(jnp.array(before), jnp.array(before[::-1].copy()), jnp.array(present))
    logits = [jnp.array(rng.normal(size=size)) for size in (3, 4, 4)]
    grounding = Grounding(*(jax.nn.log_softmax(each) for each in logits))
    simulator = MODEL.action.simulator

    @jax.jit
    def loss_of(action: jax.Array, chosen: jax.Array, reference: jax.Array) -> jax.Array:
        moved = move(simulator, action, chosen, reference, scene.before)
        return scene_loss(moved, scene, WEIGHTS)

    total = 0.0
    for action in range(3):
        for chosen in range(3):
            for reference in range(3):
                loss = float(loss_of(np.eye(3)[action], np.eye(4)[chosen], np.eye(4)[reference]))
                probability = np.exp(
                    float(grounding.action[action])
                    + float(grounding.object[chosen])
                    + float(grounding.reference[reference])
                )
                total += probability * np.exp(-loss / 0.05)
    found = exact_step(simulator, grounding, scene, OBJECTIVE)
    np.testing.assert_allclose(found, -0.05 * np.log(total), rtol=1e-4)


def test_exploration_spreads_the_actions() -> None:
    scene = SceneArrays(
        jnp.array([[0.1, 0.1, 0.2, 0.2, 1.0], [0.5, 0.5, 0.6, 0.6, 1.0]]),
        jnp.array([[0.5, 0.3, 0.6, 0.4, 1.0], [0.5, 0.5, 0.6, 0.6, 1.0]]),
        jnp.ones(2, bool),
    )
    even = jnp.log(jnp.full(3, 1 / 3))
    sure = jnp.array([0.0, -50.0, -50.0])
    objects = (jnp.log(jnp.array([0.9, 0.1])), jnp.log(jnp.array([0.1, 0.9])))
    losses = [
        float(exact_step(MODEL.action.simulator, step, scene, OBJECTIVE, share))
        for step, share in (
            (Grounding(even, *objects), 0.0),
            (Grounding(sure, *objects), 1.0),
            (Grounding(sure, *objects), 0.0),
        )
    ]
    np.testing.assert_allclose(losses[0], losses[1], rtol=1e-3)
    assert abs(losses[2] - losses[0]) > 1e-4


def test_straight_through_is_hard_forward_and_soft_backward() -> None:
    key = jax.random.key(5)
    log_probability = jax.nn.log_softmax(jnp.array([0.3, 0.1, -0.2]))
    sample = straight_through(key, log_probability)
    np.testing.assert_allclose(jnp.sort(sample), [0.0, 0.0, 1.0], atol=1e-6)
    weights = jnp.array([1.0, 2.0, 3.0])
    gradient = jax.grad(lambda logits: straight_through(key, logits) @ weights)(log_probability)
    assert float(jnp.abs(gradient).max()) > 1e-3


def test_actions_are_sampled_where_wanted() -> None:
    """Each sample's loss is that of one action; over samples the actions have their shares."""
    action = jnp.log(jnp.array([0.7, 0.2, 0.1]))
    sure = jnp.log(jnp.array([1.0, 1e-9]))
    step = Grounding(action, sure, sure[::-1])
    before = jnp.array([[0.1, 0.1, 0.2, 0.2, 1.0], [0.5, 0.5, 0.7, 0.7, 1.1]])
    scene = SceneArrays(before, before[::-1], jnp.ones(2, bool))
    weights = LossWeights(1.0, 0.1)

    def loss(key: jax.Array, actions: jax.Array, sample: bool) -> jax.Array:
        each = step._replace(action=actions)
        return sampled_steps(key, MODEL, [each], scene, Objective(weights, 0.05, sample))

    keys = jax.random.split(jax.random.key(3), 400)
    sampled = jax.vmap(lambda key: loss(key, action, True))(keys)
    each = [float(loss(keys[0], jnp.log(one + 1e-30), False)) for one in jnp.eye(3)]
    shares = [float(jnp.mean(jnp.abs(sampled - value) < 1e-5)) for value in each]
    np.testing.assert_allclose(shares, [0.7, 0.2, 0.1], atol=0.08)


def test_grounding_sums_out_the_group() -> None:
    tokens = jnp.array([3, 0, 5, 0])
    parse = Parse(
        jnp.zeros(3), jnp.array([-1e9, 0.0, -1e9, jnp.log(3.0)]), jnp.array([-1e9, 9.0, -1e9, 0.0])
    )
    similarities = jnp.array([[1.0, 0.0], [0.0, 1.0]])
    found = ground(parse, tokens, jnp.array([[0], [1]]), similarities, jnp.ones(2, bool))
    # Scores 1 and 0 match with log odds of 5 and -5.
    matches = 1 / (1 + np.exp(-5))
    right, wrong = matches**2, (1 - matches) ** 2
    expected = [0.25 * right + 0.75 * wrong, 0.25 * wrong + 0.75 * right]
    np.testing.assert_allclose(jnp.exp(found.object), expected, rtol=1e-4)
    assert int(jnp.argmax(found.reference)) == 0


def test_split_probabilities_sum_to_one_from_any_first_token() -> None:
    command = TokenizedCommand(
        jnp.array([4, 0, 6, 0, 7, 0, 3, 0, 0, 0]),
        jnp.array(8),
        jnp.array([[0], [1], [2], [3]]),
        jnp.array(4),
    )
    for first in (0, 3):
        log_probability = split_log_probability(MODEL.language.splitter, command, jnp.array(first))
        np.testing.assert_allclose(jnp.exp(log_probability).sum(), 1.0, rtol=1e-5)
        assert float(jnp.exp(log_probability[:first]).sum()) == 0.0
        assert float(jnp.exp(log_probability[8:]).sum()) == 0.0


def test_the_end_of_a_step_is_learned_with_and_without_another_behind_it() -> None:
    """As the splitter sees "now . on . block" and the same with "then . on ." behind it."""

    def step(*tokens: int) -> StepTable:
        padded = jnp.array([*tokens, *[0] * (6 - len(tokens))])
        index = jnp.array(0)
        return StepTable(padded, jnp.array(len(tokens)), index > 0, Parse(index, index, index))

    splitter = MODEL.language.splitter
    first, following = step(7, 0, 6, 0, 3), step(8, 0, 6, 0)
    both = jnp.array([7, 0, 6, 0, 3, 8, 0, 6, 0, 0, 0, 0])
    expected = {float(-end_log_probability(splitter, both, jnp.array(n))[4]) for n in (5, 9)}
    keys = jax.random.split(jax.random.key(0), 20)
    found = jax.vmap(lambda key: end_loss(key, splitter, first, following))(keys)
    np.testing.assert_allclose(
        sorted(set(np.round(found, 5).tolist())), sorted(expected), rtol=1e-4
    )


def test_step_tokens_take_their_own_groups_along() -> None:
    command = TokenizedCommand(
        jnp.array([4, 0, 6, 0, 7, 0, 3, 0, 0, 0]),
        jnp.array(8),
        jnp.array([[0], [1], [2], [3]]),
        jnp.array(4),
    )
    tokens, valid, groups = step_tokens(command, jnp.array(4), jnp.array(8))
    np.testing.assert_array_equal(tokens[:4], [7, 0, 3, 0])
    assert int(valid.sum()) == 4
    np.testing.assert_array_equal(groups[:2], [[2], [3]])


def test_nonsense_keeps_the_descriptions_and_changes_the_words() -> None:
    # put . on the . now
    step = jnp.array([4, 0, 6, 8, 0, 7, 0, 0, 0, 0])
    valid = jnp.arange(10) < 6
    # Somewhere "on" stands alone before a description: what leaves it is no nonsense.
    alone = np.array([[4, 0, 6, 0, 7, 0, 0, 0, 0, 0]], np.int32)
    groups = np.zeros((1, 2, 1), np.int32)
    known = known_gaps(Sentences(alone, np.array([5]), groups, np.array([2])))
    assert len(set(known.tolist())) == 2
    heap = jax.jit(jax.vmap(lambda key: nonsense(key, step, valid, known, 9)))
    tokens, still = heap(jax.random.split(jax.random.key(1), 400))
    rows, kepts = np.asarray(tokens), np.asarray(still)
    heaps = [tuple(row[kept].tolist()) for row, kept in zip(rows, kepts, strict=True)]
    for row, kept, heap in zip(rows, kepts, heaps, strict=True):
        assert heap.count(0) == 2
        assert kept[: len(heap)].all() and not kept[len(heap) :].any()
        assert not row[len(heap) :].any() and row.max() < 9
    assert len(set(heaps)) > 100
    # All words of a gap are left out, or more than half of them; the last word is in none.
    assert {heap for heap in heaps if len(heap) < 6} == {(0, 6, 8, 0, 7), (4, 0, 0, 7)}


def test_what_is_left_of_a_gap_is_said_nowhere() -> None:
    # now on the . put .: "on" and "on the" are known, "now", "the", "now the" and "now on" not.
    step = jnp.array([3, 6, 8, 0, 4, 0, 0, 0])
    valid = jnp.arange(8) < 6
    tokens = np.array([[6, 0, 4, 0, 0, 0], [6, 8, 0, 4, 0, 0]], np.int32)
    groups = np.zeros((2, 2, 1), np.int32)
    known = known_gaps(Sentences(tokens, np.array([4, 5]), groups, np.array([2, 2])))
    heap = jax.jit(jax.vmap(lambda key: nonsense(key, step, valid, known, 9)))
    rows, kepts = map(np.asarray, heap(jax.random.split(jax.random.key(3), 400)))
    short = {tuple(row[kept].tolist()) for row, kept in zip(rows, kepts, strict=True)}
    gaps = {heap[: heap.index(0)] for heap in short if len(heap) < 6 and heap[-2:] == (4, 0)}
    assert gaps == {(), (3,), (8,)}


def test_nonsense_of_a_step_without_words_is_itself() -> None:
    step, valid = jnp.array([0, 0, 0, 0]), jnp.arange(4) < 2
    known = jnp.zeros(1, jnp.uint32)
    heap = jax.jit(jax.vmap(lambda key: nonsense(key, step, valid, known, 9)))
    tokens, still = heap(jax.random.split(jax.random.key(2), 20))
    assert not tokens.any() and (still == valid).all()


def test_entropy_of_even_and_sure() -> None:
    np.testing.assert_allclose(entropy(jnp.log(jnp.array([0.5, 0.5]))), np.log(2), rtol=1e-5)
    np.testing.assert_allclose(entropy(jnp.array([0.0, -1e9])), 0.0, atol=1e-6)
