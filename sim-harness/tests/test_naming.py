"""Naming the learned actions of domains with few and with many actions."""

from __future__ import annotations

import itertools
import json
import tracemalloc
from typing import Any

import jax
import numpy as np
import pytest
from numpy.typing import NDArray

from nsrm_harness import domain as domains
from nsrm_harness.domain import Domain
from nsrm_harness.learning import naming
from nsrm_harness.learning.model import Dimensions, Model
from nsrm_harness.learning.naming import SENTENCES, name_actions

MOST_BYTES = 20_000_000
"""Of memory, whatever the number of actions."""


def with_actions(count: int) -> Domain:
    """The paper's domain with so many actions."""
    document: dict[str, Any] = json.loads(domains.load().as_json())
    first = document["action"][0]
    document["action"] = [
        first | {"name": f"Action{number}", "phrases": [f"relation{number}"]}
        for number in range(count)
    ]
    del document["held_out"]
    return domains.parse(document, "many.toml")


def named(
    monkeypatch: pytest.MonkeyPatch, model: Model, domain: Domain, counts: NDArray[np.int64]
) -> tuple[list[int], bool]:
    """In which order the learned actions are put where sentences mean them so often, and whether
    that is clear."""
    monkeypatch.setattr(naming, "learned_actions", lambda *_: counts)
    renamed, clear = name_actions(model, domain)
    before, after = (each.language.action_decoder.weight for each in (model, renamed))
    order = [int(np.flatnonzero((before == row).all(axis=1))[0]) for row in after]
    columns = model.action.simulator.input.weight[:, order]
    np.testing.assert_array_equal(renamed.action.simulator.input.weight[:, : len(order)], columns)
    return order, clear


@pytest.mark.slow
def test_the_most_sentences_agree_with_the_names(monkeypatch: pytest.MonkeyPatch) -> None:
    domain = with_actions(5)
    model = Model(Dimensions.of(domain), jax.random.key(0))
    rng = np.random.default_rng(2)
    for _ in range(20):
        counts = rng.integers(0, SENTENCES, (5, 5))
        order, _ = named(monkeypatch, model, domain, counts)
        agree = counts[np.arange(5), order].sum()
        assert agree == max(
            counts[np.arange(5), other].sum() for other in itertools.permutations(range(5))
        )


@pytest.mark.slow
@pytest.mark.parametrize("count", [9, 60])
def test_many_actions_are_named_in_little_memory(
    monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    domain = with_actions(count)
    model = Model(Dimensions.of(domain), jax.random.key(0))
    learned = np.random.default_rng(count).permutation(count)
    counts = SENTENCES * np.eye(count, dtype=np.int64)[learned]
    tracemalloc.start()
    try:
        order, clear = named(monkeypatch, model, domain, counts)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert (order, clear) == (learned.tolist(), True)
    assert peak < MOST_BYTES, peak
