"""The domain file: what is read from it, and what is refused with which words."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError

WORKSHOP = Path(__file__).parent / "domains" / "workshop.toml"


@pytest.fixture
def document() -> dict[str, Any]:
    return copy.deepcopy(tomllib.loads(domains.DEFAULT.read_text(encoding="utf-8")))


def test_the_default_is_the_papers() -> None:
    domain = domains.load()
    assert [value.name for value in domain.attribute("color").values] == [
        "red", "green", "blue", "magenta", "yellow", "cyan", "white",
    ]  # fmt: skip
    assert [value.name for value in domain.attribute("size").values] == ["lego", "small"]
    assert [action.name for action in domain.actions] == ["MoveOn", "MoveRight", "MoveLeft"]
    assert [value.name for value in domain.concepts][-2:] == ["lego", "small"]


def test_the_vocabulary_is_sorted_behind_the_group_token_and_without_lexicon() -> None:
    domain = domains.load()
    vocabulary = domain.vocabulary()
    assert vocabulary[0] == domains.GROUP_TOKEN
    assert vocabulary[1:] == sorted(set(vocabulary[1:]))
    assert {",", "then", "upon", "side", "please", "the"} <= set(vocabulary)
    assert not set(vocabulary) & set(domain.lexicon())
    assert domain.lexicon()["small"] == 8


def test_synonyms_share_a_concept() -> None:
    domain = domains.load(WORKSHOP)
    lexicon = domain.lexicon()
    assert lexicon["violet"] == lexicon["purple"] == 1
    assert len(domain.concepts) == 8


def test_json_carries_the_whole_file(document: dict[str, Any]) -> None:
    domain = domains.load()
    assert domains.from_json(domain.as_json(), "a model") == domain
    import json

    assert json.loads(domain.as_json()) == document


def _set(document: dict[str, Any], path: str, value: Any) -> None:
    *parents, last = path.split(".")
    place: Any = document
    for key in parents:
        place = place[int(key) if key.isdigit() else key]
    key = int(last) if last.isdigit() else last
    if value is None:
        del place[key]
    else:
        place[key] = value


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("name", "two words", "name: expected a name of letters"),
        ("name", None, "name: is missing"),
        ("atribute", [], "atribute: unknown key"),
        ("attribute.0.view", "infrared", "attribute[0].view: expected one of color, brightness"),
        ("attribute.0.values", [], "attribute[0].values: expected 2 or more tables"),
        ("attribute.0.values.1.rgb", [0, 2, 0], "attribute[0].values[1].rgb: expected 3 numbers"),
        ("attribute.0.values.1.rgb", None, "color.green: rgb is missing"),
        ("attribute.0.values.1.words", ["light green"], "single words"),
        ("attribute.0.values.1.words", ["Green"], "lower-case words"),
        ("attribute.0.values.1.words", ["Émeraude"], "lower-case words"),
        ("attribute.0.values.1.words", ["red"], "'red' already names 'red'"),
        ("attribute.0.values.1.words", ["block"], "'block' names the concept 'green'"),
        ("attribute.0.values.1.name", "red", "the name 'red' is given twice"),
        ("attribute.0.values.1.edges_m", [0.1, 0.1, 0.1], "more than one attribute type"),
        ("attribute.1.values.0.studs", [2, 0], "expected 2 whole numbers in 1..8"),
        ("attribute.1.values.0.edges_m", [0.06, -0.06, 0.05], "expected 3 numbers"),
        ("action.0.place", "under", "action[0].place: expected one of on, beside"),
        ("action.0.direction", [0.0, 1.0], "action[0].direction: only"),
        ("action.1.direction", [0.6, 0.8], "action[1].direction: expected one of [1, 0]"),
        ("action.1.direction", None, "action[1].direction: expected one of [1, 0]"),
        ("action.0.phrases", ["on", ""], "cannot be left unsaid"),
        ("grammar.verbs", ["put", "Put"], "grammar.verbs: expected lower-case words"),
        ("grammar.verbs", ["put", "put"], "'put' is given twice"),
        ("grammar.verbs", ["put", ""], "run together"),
        ("grammar.commands", ["{verb} {moved} {relation}"], "{reference} must stand once"),
        ("grammar.commands", ["{moved} {reference} {relation} {verb}"], "no word between"),
        ("grammar.commands", ["{moved} {relation} {reference} {verb}"], "cannot begin with"),
        ("grammar.commands", ["{verb} {moved} {relation} {reference} {noun}"], "or fields"),
        ("grammar.connectives", "and", "grammar.connectives: expected a list"),
        ("grammar.connectives", ["and  then"], "single spaces"),
    ],
)
def test_refusals_name_key_and_fault(
    document: dict[str, Any], path: str, value: Any, message: str
) -> None:
    _set(document, path, value)
    with pytest.raises(DomainError) as caught:
        domains.parse(document, "some.toml")
    assert str(caught.value).startswith("some.toml: ")
    assert message in str(caught.value)


def test_more_attribute_types_than_filters_are_refused(document: dict[str, Any]) -> None:
    for number in range(3):
        document["attribute"].append(
            {
                "name": f"extra{number}",
                "view": "color",
                "values": [
                    {"name": f"{side}{number}", "words": [f"{side}{number}"]} for side in "ab"
                ],
            }
        )
    with pytest.raises(DomainError, match="at most 4 types, got 5"):
        domains.parse(document, "some.toml")


@pytest.mark.parametrize("content", [None, "name = ", b"\xff\xfe"])
def test_unreadable_files_are_refused(tmp_path: Path, content: str | bytes | None) -> None:
    path = tmp_path / "broken.toml"
    if content is not None:
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(DomainError, match=r"broken\.toml"):
        domains.load(path)
