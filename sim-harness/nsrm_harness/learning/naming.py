"""Names the learned actions.

The final scenes show that there are different actions, but not their names: the order of the
learned actions is arbitrary. The domain file lists phrases for each action; after training, the
model itself is asked which of its actions each phrase means. Nothing is learned here: rows and
columns are permuted.
"""

from __future__ import annotations

import itertools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy.optimize import linear_sum_assignment

from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar, Style
from nsrm_harness.domain.program import Step
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.learning.dataset import Sentences
from nsrm_harness.learning.model import Model

SENTENCES = 64
"""Number of sentences per action."""
AGREEMENT = 0.8
"""Smallest share of an action's sentences that must mean the same learned action."""


def learned_actions(model: Model, domain: Domain) -> np.ndarray:
    """How often the model chooses each of its own actions, by action of the domain: `[A, A]`."""
    rng = np.random.default_rng(0)
    grammar, tokenizer = Grammar(domain, Style()), Tokenizer(domain)
    # The described objects do not matter: all descriptions are the same token.
    concept = (domain.concepts[0].name,)
    sentences = [
        tokenizer(grammar.sentence(rng, (Step(action.name, concept, concept),)).text)
        for action, _ in itertools.product(domain.actions, range(SENTENCES))
    ]
    padded = Sentences.of(tokenizer, sentences)
    valid = np.arange(padded.tokens.shape[1]) < padded.length[:, None]
    meant = np.asarray(_meant(model, jnp.asarray(padded.tokens), jnp.asarray(valid)))
    meant = meant.reshape(len(domain.actions), SENTENCES)
    return np.stack([np.bincount(row, minlength=len(domain.actions)) for row in meant])


@eqx.filter_jit
def _meant(model: Model, tokens: Array, valid: Array) -> Array:
    return jnp.argmax(jax.vmap(model.language.parse)(tokens, valid).action, axis=1)


def name_actions(model: Model, domain: Domain) -> tuple[Model, bool]:
    """The model with its actions in the domain's order, and whether each name was clear.

    It is not clear if learned actions merged: two names then mean the same one.
    """
    counts = learned_actions(model, domain)
    count = len(domain.actions)
    # Each learned action gets one name, so that as many sentences as possible agree.
    _, order = linear_sum_assignment(counts, maximize=True)
    clear = bool((counts[np.arange(count), order] >= AGREEMENT * SENTENCES).all())
    decoder, first = model.language.action_decoder, model.action.simulator.input
    assert decoder.bias is not None, "the decoder is made with a bias"
    columns = np.concatenate([order, np.arange(count, first.weight.shape[1])])
    named = eqx.tree_at(
        lambda m: (
            m.language.action_decoder.weight,
            m.language.action_decoder.bias,
            m.action.simulator.input.weight,
        ),
        model,
        (decoder.weight[order], decoder.bias[order], first.weight[:, columns]),
    )
    return named, clear
