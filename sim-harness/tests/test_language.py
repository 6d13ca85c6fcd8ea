"""Sentences and tokens: every sentence parses back to its program."""

from __future__ import annotations

import itertools
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError
from nsrm_harness.domain import GROUP_TOKEN, Domain
from nsrm_harness.domain.grammar import Grammar, Style
from nsrm_harness.domain.letters import lower_case, upper_case
from nsrm_harness.domain.program import Program, Step, canonical
from nsrm_harness.domain.tokens import Tokenizer, UnknownWordError, split

WORKSHOP = Path(__file__).parent / "domains" / "workshop.toml"
LETTERS = Path(__file__).parent / "domains" / "letters.toml"


@pytest.fixture(
    params=[domains.DEFAULT, WORKSHOP, LETTERS], ids=["tabletop", "workshop", "letters"]
)
def domain(request: pytest.FixtureRequest) -> Domain:
    return domains.load(request.param)


def random_program(rng: np.random.Generator, domain: Domain) -> Program:
    def description() -> tuple[str, ...]:
        count = int(rng.integers(1, len(domain.attributes) + 1))
        chosen = rng.permutation(len(domain.attributes))[:count]
        return tuple(str(rng.choice([v.name for v in domain.attributes[i].values])) for i in chosen)

    return tuple(
        Step(str(rng.choice([a.name for a in domain.actions])), description(), description())
        for _ in range(int(rng.integers(1, 4)))
    )


def test_every_sentence_reads_back(domain: Domain) -> None:
    grammar, tokenizer = Grammar(domain), Tokenizer(domain)
    rng = np.random.default_rng(11)
    both_orders = set()
    for _ in range(1500):
        program = random_program(rng, domain)
        sentence = grammar.sentence(rng, program).text
        tokens = tokenizer(sentence)
        named = [{domain.concepts[index].name for index in group} for group in tokens.groups]
        expected = [[set(step.object), set(step.reference)] for step in program]
        assert len(named) == 2 * len(program), sentence
        for step, pair in enumerate(expected):
            found = named[2 * step : 2 * step + 2]
            assert found in (pair, pair[::-1]), sentence
            both_orders.add(found == pair)
        assert tokens.words.count(GROUP_TOKEN) == len(tokens.groups)
        assert all(word in tokenizer.row for word in tokens.words), sentence
    assert both_orders == {True, False}


def test_every_word_of_the_vocabulary_is_said(domain: Domain) -> None:
    grammar, tokenizer = Grammar(domain), Tokenizer(domain)
    rng = np.random.default_rng(12)
    said = set()
    for _ in range(1500):
        said |= set(tokenizer(grammar.sentence(rng, random_program(rng, domain)).text).words)
    assert said == set(domain.vocabulary())


def test_sentences_are_natural_text(domain: Domain) -> None:
    grammar = Grammar(domain)
    rng = np.random.default_rng(13)
    sentences = [grammar.sentence(rng, random_program(rng, domain)).text for _ in range(1500)]
    for sentence in sentences:
        assert not re.search(r"  | ,|,\S|^\W|\s$|\.\.", sentence), sentence
    text = " ".join(sentences)
    # "a red" is no description without its noun.
    values = "|".join(domain.lexicon())
    nouns = "|".join(domain.grammar.nouns)
    for found in re.findall(rf"\ba (?:(?:{values}) )+(\w+)", text.lower()):
        assert re.fullmatch(nouns, found), found
    assert any(sentence.endswith(".") for sentence in sentences)
    assert any(sentence[0].isupper() and not sentence.isupper() for sentence in sentences)
    assert any(sentence == upper_case(sentence) for sentence in sentences)


def test_openings_stand_at_the_beginning_only() -> None:
    domain = domains.load()
    grammar = Grammar(domain, Style(capital=0, shouted=0, mixed=0))
    rng = np.random.default_rng(14)
    for _ in range(300):
        words = grammar.sentence(rng, random_program(rng, domain)).text.split()
        assert not {"please", "now", "first"} & set(words[1:])


def test_the_same_draws_give_the_same_sentence(domain: Domain) -> None:
    program = random_program(np.random.default_rng(3), domain)
    first, again = (Grammar(domain).sentence(np.random.default_rng(5), program) for _ in range(2))
    assert first == again


def test_each_step_ends_where_its_words_end(domain: Domain) -> None:
    grammar, tokenizer = Grammar(domain), Tokenizer(domain)
    rng = np.random.default_rng(15)
    for _ in range(300):
        program = random_program(rng, domain)
        said = grammar.sentence(rng, program)
        assert len(said.ends) == len(program)
        first = 0
        for end in said.ends:
            assert len(tokenizer(said.text[first:end]).groups) == 2, said
            assert end == len(said.text) or said.text[end] in " ,.", said
            first = end
        assert said.text[first:] in ("", ".")


@pytest.mark.slow
def test_held_out_wordings_are_new_and_read_back() -> None:
    domain = domains.load()
    tokenizer = Tokenizer(domain)
    rng = np.random.default_rng(16)
    shapes: list[set[str]] = []
    phrases = {phrase for action in domain.actions for phrase in action.phrases}
    for grammar in (
        Grammar(domain),
        Grammar(domain, held_out=True),
        Grammar(domain, held_out=True, held_out_phrases=True),
    ):
        shapes.append(set())
        for _ in range(3000):
            program = random_program(rng, domain)[:1]
            (command,) = grammar.commands(rng, program)
            assert (command.fields["relation"] in phrases) == (len(shapes) < 3)
            said = grammar.sentence(rng, program).text
            tokens = tokenizer(said)
            assert len(tokens.groups) == 2, said
            shapes[-1].add(" ".join(tokens.words))
    assert not shapes[0] & shapes[1]
    assert not shapes[2] & (shapes[0] | shapes[1])


def test_a_domain_without_held_out_wordings_says_so() -> None:
    with pytest.raises(DomainError, match=r"no \[held_out\] wordings"):
        Grammar(domains.load(WORKSHOP), held_out=True)


@pytest.mark.parametrize(
    ("sentence", "pieces"),
    [
        ("Put RED on\tblue .\n", ["put", "red", "on", "blue"]),
        ("put red;on blue,then", ["put", "red", ",", "on", "blue", ",", "then"]),
        ("put red on blue!?.", ["put", "red", "on", "blue"]),
        ("put red. on blue.", ["put", "red", ".", "on", "blue"]),
        ("put 'red' on blue", ["put", "'", "red", "'", "on", "blue"]),
        ("it's a.b", ["it's", "a.b"]),
        ("red, , blue", ["red", ",", ",", "blue"]),
        (" . ", []),
        ("red\u2003blue\x85on", ["red", "blue", "on"]),
        # Separators of files and records are no white space.
        ("red\x1cblue on\x1f", ["red\x1cblue", "on\x1f"]),
        ("WEIẞ, Weiß; WEISS", ["weiß", ",", "weiß", ",", "weiss"]),
        ("ΛΕΥΚΟΣ. ΛΕΥΚΟΣ", ["λευκοσ", ".", "λευκοσ"]),
        ("Kırmızı KIRMIZI İ", ["kırmızı", "kirmizi", "i\u0307"]),
    ],
)
def test_splitting(sentence: str, pieces: list[str]) -> None:
    assert split(sentence) == pieces


def test_upper_case_reads_back_whatever_the_letter() -> None:
    letters = [chr(code) for code in range(sys.maxunicode + 1) if not 0xD800 <= code < 0xE000]
    for letter in letters:
        if lower_case(letter) == letter:
            spelt = upper_case(letter)
            assert len(spelt) == 1 and lower_case(spelt) == letter, letter
    assert upper_case("größer, ça kırmızı λευκός ŉ") == "GRÖßER, ÇA KıRMıZı ΛΕΥΚΌς ŉ"


@pytest.mark.parametrize(
    "style",
    [Style(capital=1), Style(capital=0, shouted=1), Style(capital=0, shouted=0, mixed=1)],
    ids=["capital", "shouted", "mixed"],
)
def test_a_spelling_is_as_long_as_the_words_and_reads_as_they_do(style: Style) -> None:
    domain = domains.load(LETTERS)
    tokenizer, plain = Tokenizer(domain), Style(capital=0, shouted=0, mixed=0)
    for seed in range(300):
        program = random_program(np.random.default_rng(seed), domain)
        said, lower = (
            Grammar(domain, each).sentence(np.random.default_rng(seed), program)
            for each in (style, plain)
        )
        assert said.ends == lower.ends
        assert tokenizer(said.text) == tokenizer(lower.text), said.text
        assert len(said.text.rstrip(".")) == len(lower.text.rstrip("."))


def test_groups_hold_neighbours_only() -> None:
    tokens = Tokenizer(domains.load())("put the small green block on lego red, then red")
    assert tokens.words == (
        "put", "the", GROUP_TOKEN, "block", "on", GROUP_TOKEN, ",", "then", GROUP_TOKEN,
    )  # fmt: skip
    assert tokens.groups == ((8, 1), (7, 0), (0,))


def test_quotation_marks_are_white_space_and_apostrophes_are_one() -> None:
    assert split("“Put 'the' \"red\" block’s.”") == split("put 'the' red block's")
    assert split("„red” 1. blue:") == ["red", "1", ".", "blue", ":"]


@pytest.mark.parametrize("word", ["sofa", GROUP_TOKEN, "'", "rot"])
def test_unknown_words_are_named(word: str) -> None:
    with pytest.raises(UnknownWordError) as caught:
        Tokenizer(domains.load())(f"put {word} on blue")
    assert caught.value.word == word.lower()


def test_canonical_text_ignores_the_order_of_filters_only() -> None:
    step = Step("MoveOn", ("small", "red"), ("blue",))
    same = Step("MoveOn", ("red", "small"), ("blue",))
    others = [
        Step("MoveLeft", ("small", "red"), ("blue",)),
        Step("MoveOn", ("blue",), ("small", "red")),
        Step("MoveOn", ("small",), ("red", "blue")),
    ]
    assert canonical([step]) == canonical([same])
    texts = [canonical([each]) for each in (step, *others)]
    assert all(a != b for a, b in itertools.combinations(texts, 2))
    assert Step.from_json(step.as_json()) == step
