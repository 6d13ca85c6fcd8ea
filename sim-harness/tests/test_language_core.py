"""The core tokenises sentences like the trainer: the same words, and the same unknown word."""

from __future__ import annotations

import jax
import nsrm
import numpy as np
import pytest
from test_language import LETTERS, random_program

from nsrm_harness import domain as domains
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar, Style
from nsrm_harness.domain.tokens import Tokenizer, UnknownWordError
from nsrm_harness.learning.export import ModelFile, Thresholds, WorkSpace, write_model
from nsrm_harness.learning.model import Dimensions, Model


@pytest.fixture(scope="module")
def domain() -> Domain:
    return domains.load(LETTERS)


@pytest.fixture(scope="module")
def core(domain: Domain, tmp_path_factory: pytest.TempPathFactory) -> nsrm.Model:
    """Has learned nothing."""
    path = tmp_path_factory.mktemp("letters") / "model.safetensors"
    model = Model(Dimensions.of(domain), jax.random.key(0))
    space = WorkSpace((0.3, -0.2, 0.0), (0.6, 0.2, 0.2))
    write_model(path, ModelFile(model, domain, Thresholds(0.5, 0.0), space))
    return nsrm.Model.load(path)


def unknown_to(core: nsrm.Model, sentence: str) -> str | None:
    """The word that the core does not know, as it stands in the sentence."""
    try:
        core.parse(sentence)
    except nsrm.Refused as refusal:
        return refusal.details["words"]["text"] if refusal.kind == "unknown_word" else None
    return None


@pytest.mark.parametrize(
    "style",
    [Style(), Style(capital=0, shouted=1), Style(capital=0, shouted=0, mixed=1)],
    ids=["usual", "shouted", "mixed"],
)
def test_every_word_that_the_grammar_says_is_known_to_the_core(
    domain: Domain, core: nsrm.Model, style: Style
) -> None:
    grammar, rng = Grammar(domain, style), np.random.default_rng(3)
    for _ in range(300):
        sentence = grammar.sentence(rng, random_program(rng, domain)[:1]).text
        assert unknown_to(core, sentence) is None, sentence


@pytest.mark.parametrize(
    ("word", "is_known"),
    [
        ("WEIẞ", True),
        ("WEIß", True),
        ("WEISS", False),
        ("ΛΕΥΚΌς", True),
        ("ΛΕΥΚΌΣ", False),
        ("KıRMıZı", True),
        ("KIRMIZI", False),
        ("GRÜN", True),
        # With its accent apart.
        ("gru\u0308n", False),
        ("ŉKLEIN", True),
        ("ʼNKLEIN", False),
        ("ﬂaschenGRÜN", True),
        ("flaschengrün", False),
        ("grün\x1c", False),
        ("grün\u2003rouge", True),
        ("grün\x85rouge", True),
        ('"grün" “rouge”', True),
        ('grün"rouge', True),
    ],
)
def test_both_know_the_same_words(
    domain: Domain, core: nsrm.Model, word: str, is_known: bool
) -> None:
    sentence = f"stoße den {word} klotz auf den küçük klotz"
    try:
        Tokenizer(domain)(sentence)
    except UnknownWordError as error:
        assert not is_known and error.word == "".join(map(str.lower, word))
    else:
        assert is_known
    assert unknown_to(core, sentence) == (None if is_known else word)
