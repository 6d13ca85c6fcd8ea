"""The words that count steps, "third" and "3.", where demonstrations have no more than two.

No final scene shows what they mean before a later step, and near misses have them in other places
only. They are read as the words that count the second step.
"""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp

from nsrm_harness.domain import Domain
from nsrm_harness.domain.reader import COUNTING
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.learning.model import Model

SHOWN = 2
"""Number of steps that demonstrations have at most."""


def later_words(domain: Domain) -> dict[int, int]:
    """For each word that counts a step that no demonstration has, the one that it is read as: rows
    of the embeddings."""
    if domain.everyday is None:
        return {}
    tokenizer, rows = Tokenizer(domain), {}
    for name in COUNTING:
        texts = domain.everyday.rules.get(name, ())
        for text in texts[SHOWN:]:
            known, later = (tokenizer.rows(tokenizer(each)) for each in (texts[SHOWN - 1], text))
            rows |= {new: old for old, new in zip(known, later, strict=True) if new != old}
    return rows


def with_later_words(model: Model, domain: Domain) -> Model:
    """The model that reads them as the words for the last step that demonstrations have."""
    rows = later_words(domain)
    if not rows:
        return model
    later, known = (jnp.array(list(each)) for each in (rows.keys(), rows.values()))

    def embeddings(model: Model) -> tuple[eqx.nn.Embedding, eqx.nn.Embedding]:
        return model.language.embedding, model.language.splitter.embedding

    read = [
        eqx.tree_at(lambda each: each.weight, each, each.weight.at[later].set(each.weight[known]))
        for each in embeddings(model)
    ]
    return eqx.tree_at(embeddings, model, tuple(read))
