"""The domain file: what is read from it, and the messages of its errors."""

from __future__ import annotations

import copy
import json
import math
import tomllib
from pathlib import Path
from typing import Any

import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError

WORKSHOP = Path(__file__).parent / "domains" / "workshop.toml"


def test_a_domain_extends_another_one() -> None:
    paper, wide = domains.load(), domains.load(domains.FOUR_SIDES)
    assert wide.attributes == paper.attributes and wide.grammar == paper.grammar
    assert wide.actions[: len(paper.actions)] == paper.actions
    assert [action.direction for action in wide.actions[3:]] == [(1.0, 0.0), (-1.0, 0.0)]
    assert paper.held_out is not None and wide.held_out is not None
    assert wide.held_out.phrases["MoveOn"] == paper.held_out.phrases["MoveOn"]
    assert wide.held_out.phrases["MoveBehind"] == ("to the back side of",)
    assert "extends" not in json.loads(wide.as_json())


@pytest.mark.parametrize(
    ("extended", "problem"),
    [
        ("3", "extends: expected the name of a file, got 3"),
        ("'other.toml'", "other.toml: cannot read the domain file"),
        ("'domain.toml'", "extends: domain.toml extends this file"),
    ],
)
def test_what_cannot_be_extended_is_named(extended: str, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "domain.toml"
    path.write_text(f"extends = {extended}\n", encoding="utf-8")
    with pytest.raises(DomainError, match=problem):
        domains.load(path)


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
        (
            "attribute.0.view",
            "infrared",
            "attribute[0].view: expected 'color' or 'brightness', got 'infrared'",
        ),
        ("attribute.0.values", [], "attribute[0].values: expected 2 or more entries, got []"),
        (
            "attribute.0.values.1.rgb",
            [0, 2, 0],
            "attribute[0].values[1].rgb[1]: must be at most 1, got 2",
        ),
        ("attribute.0.values.1.rgb", None, "color.green: rgb is missing"),
        ("attribute.0.values.1.words", ["light green"], "expected a single word"),
        ("attribute.0.values.1.words", ["Green"], "lower-case words"),
        ("attribute.0.values.1.words", ["Émeraude"], "lower-case words"),
        ("attribute.0.values.1.words", ["red"], "'red' already names the concept 'red'"),
        ("attribute.0.values.1.words", ["block"], "'block' names the concept 'green'"),
        ("attribute.0.values.1.name", "red", "duplicate name 'red'"),
        ("action.0.name", "Nearest", "Nearest is a relation of every domain"),
        ("attribute.0.values.1.edges_m", [0.1, 0.1, 0.1], "more than one attribute type"),
        (
            "attribute.1.values.0.studs",
            [2, 0],
            "attribute[1].values[0].studs[1]: must be at least 1, got 0",
        ),
        (
            "attribute.1.values.0.edges_m",
            [0.06, -0.06, 0.05],
            "attribute[1].values[0].edges_m[1]: must be at least 0.01",
        ),
        ("action.0.place", "under", "action[0].place: expected 'on' or 'beside', got 'under'"),
        ("action.0.direction", [0.0, 1.0], "action[0].direction: only"),
        ("action.1.direction", [0.6, 0.8], "action[1].direction: expected one of [1, 0]"),
        ("action.1.direction", None, "action[1].direction: expected one of [1, 0]"),
        ("action.0.phrases", ["on", ""], "an action needs a phrase"),
        ("grammar.verbs", ["put", "Put"], "grammar.verbs[1]: expected lower-case words"),
        ("grammar.verbs", ["put", "put"], "duplicate 'put'"),
        ("grammar.verbs", ["put", ""], "would join two descriptions"),
        ("grammar.commands", ["{verb} {moved} {relation}"], "{reference} must occur once"),
        ("grammar.commands", ["{moved} {reference} {relation} {verb}"], "no word between"),
        ("grammar.commands", ["{moved} {relation} {reference} {verb}"], "cannot begin with"),
        ("grammar.commands", ["{verb} {moved} {relation} {reference} {noun}"], "or fields"),
        ("grammar.connectives", "and", "grammar.connectives: expected a list, got 'and'"),
        ("grammar.connectives", ["and  then"], "single spaces"),
        ("grammar.order_words", ["then"], "grammar.order_words: expected openings with one word"),
        ("grammar.order_words", [], "grammar.order_words: expected 1 or more entries"),
        ("attribute", "color", "attribute: expected a list, got 'color'"),
        ("attribute.0", "color", "attribute[0]: expected a table, got 'color'"),
        ("attributes", [], "attributes: unknown key; expected some of: action, apart, arr"),
        (
            "document",
            "{}",
            "document: unknown key; expected some of: action, apart, arr",
        ),
        ("attribute.0.values.1.attribute", "color", "attribute[0].values[1].attribute: unknown"),
        ("attribute.0.values.1.color", [], "color: unknown key; expected some of: edges_m, name, "),
        ("attribute.0.values.1.name", 5, "attribute[0].values[1].name: should be a valid string"),
        ("attribute.0.values.1.rgb", [0, 1], "attribute[0].values[1].rgb[2]: is missing"),
        ("attribute.0.values.1.rgb", [0, 1, 0, 1], "rgb: expected 3 or fewer entries"),
        ("attribute.0.values.1.rgb", [0, True, 1], "rgb[1]: should be a valid number, got True"),
        ("attribute.0.values.1.rgb", [0, "1", 1], "rgb[1]: should be a valid number, got '1'"),
        ("attribute.0.values.1.rgb", [0, math.nan, 1], "rgb[1]: should be a finite number"),
        ("attribute.1.values.0.studs", [2, 1.5], "studs[1]: should be a valid integer, got 1.5"),
        ("attribute.1.values.0.studs", [2, 2.0], "studs[1]: should be a valid integer, got 2.0"),
        ("attribute.1.values.0.studs", [2, True], "studs[1]: should be a valid integer, got True"),
        ("action.0.phrases.0", 3, "action[0].phrases[0]: should be a valid string, got 3"),
        ("held_out.phrases.MoveOn", None, "held_out.phrases.MoveOn: is missing"),
        ("held_out.phrases.MoveUp", ["up"], "held_out.phrases.MoveUp: unknown action; expected"),
        ("held_out.phrases.MoveOn", ["on"], "held_out: 'on' is not held out"),
        (
            "held_out.phrases.MoveOn",
            ["atop of us"],
            "'us' in 'atop of us' is not a word of the grammar",
        ),
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


def test_each_fault_has_a_line(document: dict[str, Any]) -> None:
    document["attribute"][0]["values"][1]["rgb"] = [0.0, 2.0, 0.0]
    document["grammar"]["verb"] = ["put"]
    del document["action"][2]["place"]
    with pytest.raises(DomainError) as caught:
        domains.parse(document, "some.toml")
    assert [line.partition(";")[0] for line in str(caught.value).splitlines()] == [
        "some.toml: attribute[0].values[1].rgb[1]: must be at most 1, got 2.0",
        "some.toml: action[2].place: is missing",
        "some.toml: grammar.verb: unknown key",
    ]


def test_a_wrong_value_is_no_missing_one(document: dict[str, Any]) -> None:
    """The list with it is not too short."""
    document["attribute"][1]["values"][0]["studs"] = "2 by 2"
    with pytest.raises(DomainError) as caught:
        domains.parse(document, "some.toml")
    key = "attribute[1].values[0].studs"
    assert str(caught.value) == f"some.toml: {key}: expected a list, got '2 by 2'"


@pytest.mark.parametrize("key", ["held_out", "grammar", "name", "action"])
def test_what_json_has_as_null_is_refused(document: dict[str, Any], key: str) -> None:
    document[key] = None
    with pytest.raises(DomainError, match=f"^a model: {key}: .*None"):
        domains.from_json(json.dumps(document), "a model")


def test_long_values_are_shown_in_part(document: dict[str, Any]) -> None:
    document["action"] = "n" * 1000
    with pytest.raises(DomainError) as caught:
        domains.parse(document, "some.toml")
    assert f"action: expected a list, got '{79 * 'n'}…" in str(caught.value)


def test_held_out_phrases_stand_in_any_order(document: dict[str, Any]) -> None:
    phrases = document["held_out"]["phrases"]
    document["held_out"]["phrases"] = dict(reversed(phrases.items()))
    read, default = domains.parse(document, "some.toml"), domains.load()
    assert read.held_out == default.held_out


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
