"""The domain: what may be named, what may be done, in which words (Table I).

A domain is one TOML file. Everything else that depends on it is made from it:
episodes, the network's dimensions, the model file, the static arrays, the docs.

* Concepts are the values of all attribute types, in the file's order.
* The lexicon holds the words that name a concept; the vocabulary all other words
  that the grammar can produce, after the group token that stands for a run of
  lexicon words.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from nsrm_harness.common.errors import DomainError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.domain.reader import Table

#: The paper's domain.
DEFAULT = Path(__file__).resolve().parent / "tabletop.toml"
#: Stands for a run of concept words, ``[[X]]`` in section IV-B; row 0 of embeddings.
GROUP_TOKEN = "[[X]]"
#: Most concepts that may describe one object, a capacity of the core: a domain
#: has no more attribute types than this.
MAX_ATTRIBUTES = 4
#: Indices of concepts and actions are bytes in the core.
MAX_CONCEPTS = 255

View = Literal["color", "brightness"]
Place = Literal["on", "beside"]


@dataclass(frozen=True)
class Value:
    """One value of an attribute type: a concept."""

    name: str
    #: Name of its attribute type.
    attribute: str
    #: How a person says it; single words in lower case.
    words: tuple[str, ...]
    #: Colour of a block that has this value, each channel in 0..1.
    rgb: tuple[float, float, float] | None = None
    #: Length of such a block along its x, y and z axes, metres.
    edges_m: tuple[float, float, float] | None = None
    #: Rows (along x) and columns (along y) of studs on its top face.
    studs: tuple[int, int] | None = None


@dataclass(frozen=True)
class Attribute:
    """An attribute type with its values."""

    name: str
    #: What of a crop its operator sees.
    view: View
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Action:
    """What can be done with an object with regard to another."""

    name: str
    place: Place
    #: For ``beside``: unit vector (x, y) of the world along one of its axes.
    direction: tuple[float, float] | None
    #: How a person says it, between the two objects.
    phrases: tuple[str, ...]


@dataclass(frozen=True)
class GrammarWords:
    """How a command is said. An empty string: may be left out."""

    openings: tuple[str, ...]
    verbs: tuple[str, ...]
    nouns: tuple[str, ...]
    #: Templates with ``{values}`` and perhaps ``{noun}``.
    descriptions: tuple[str, ...]
    #: Templates with ``{verb}``, ``{moved}``, ``{relation}``, ``{reference}``, each once.
    commands: tuple[str, ...]
    connectives: tuple[str, ...]
    #: Openings of one word that mean something else anywhere but at the start of a sentence.
    order_words: tuple[str, ...] = ()


@dataclass(frozen=True)
class HeldOut:
    """Wordings that training never hears, made of words that it knows."""

    #: Templates like the grammar's.
    commands: tuple[str, ...]
    #: Phrases of each action, by its name.
    phrases: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Domain:
    """A domain file, checked."""

    name: str
    attributes: tuple[Attribute, ...]
    actions: tuple[Action, ...]
    grammar: GrammarWords
    held_out: HeldOut | None
    #: :meth:`as_json`'s text, kept so that the file's content travels unchanged.
    document: str

    @cached_property
    def concepts(self) -> tuple[Value, ...]:
        """The values of all attribute types, in order."""
        return tuple(value for attribute in self.attributes for value in attribute.values)

    def attribute(self, name: str) -> Attribute:
        """The attribute type of that name; ``KeyError`` if there is none."""
        return _named(self.attributes, name)

    def concept(self, name: str) -> Value:
        """The attribute value of that name; ``KeyError`` if there is none."""
        return _named(self.concepts, name)

    def action(self, name: str) -> Action:
        """The action of that name; ``KeyError`` if there is none."""
        return _named(self.actions, name)

    def lexicon(self) -> dict[str, int]:
        """Words that name a concept, sorted, each with the concept's index."""
        words = {word: index for index, value in enumerate(self.concepts) for word in value.words}
        return dict(sorted(words.items()))

    def vocabulary(self) -> list[str]:
        """The group token, then every other token that the grammar produces, sorted."""
        return [GROUP_TOKEN, *sorted(_grammar_words(self.grammar, self.actions))]

    def as_json(self) -> str:
        """The whole file as JSON, keys in the file's order; it goes into the model file."""
        return self.document


def load(path: Path | str = DEFAULT) -> Domain:
    """Read and check a domain file; ``DomainError`` says file, key and what is wrong."""
    path = Path(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise DomainError(f"{path}: cannot read the domain file: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise DomainError(f"{path}: not TOML: {error}") from error
    return parse(document, str(path))


def from_json(text: str, source: str) -> Domain:
    """The domain that an episode or model file carries; `source` names it in errors."""
    try:
        document = json.loads(text)
    except ValueError as error:
        raise DomainError(f"{source}: the domain is not JSON: {error}") from error
    if not isinstance(document, dict):
        raise DomainError(f"{source}: the domain is not a JSON object")
    return parse(document, source)


def parse(document: Mapping[str, Any], source: str) -> Domain:
    """Check a document as read from TOML or JSON; `source` names it in errors."""
    root = Table(document, source, "")
    attributes = tuple(_attribute(table) for table in root.tables("attribute"))
    actions = tuple(_action(table) for table in root.tables("action"))
    grammar = _grammar(root.table("grammar"))
    held_out = _held_out(root.table("held_out"), actions) if "held_out" in document else None
    name = root.identifier("name")
    root.no_other_keys()
    text = json_text(document, ensure_ascii=False)
    domain = Domain(name, attributes, actions, grammar, held_out, text)
    _check_names(root, domain)
    _check_appearance(root, domain)
    _check_words(root, domain)
    _check_held_out(root, domain)
    return domain


def _attribute(table: Table) -> Attribute:
    name = table.identifier("name")
    seen = table.choice("view", ("color", "brightness"))
    view: View = "color" if seen == "color" else "brightness"
    values = tuple(_value(value, name) for value in table.tables("values", least=2))
    table.no_other_keys()
    return Attribute(name, view, values)


def _value(table: Table, attribute: str) -> Value:
    name = table.identifier("name")
    words = table.phrases("words")
    for word in words:
        if " " in word or word == "," or not word:
            raise table.error("words", f"a concept is named by single words, got {word!r}")
    value = Value(
        name,
        attribute,
        words,
        rgb=_three(table.numbers("rgb", 3, 0.0, 1.0)),
        edges_m=_three(table.numbers("edges_m", 3, 0.01, 0.2)),
        studs=_two(table.integers("studs", 2, 1, 8)),
    )
    table.no_other_keys()
    return value


def _action(table: Table) -> Action:
    name = table.identifier("name")
    place: Place = "on" if table.choice("place", ("on", "beside")) == "on" else "beside"
    numbers = table.numbers("direction", 2, -1.0, 1.0)
    direction = None if numbers is None else (numbers[0], numbers[1])
    if place == "on" and direction is not None:
        raise table.error("direction", 'only an action with place = "beside" has one')
    if place == "beside" and (direction is None or sorted(map(abs, direction)) != [0.0, 1.0]):
        raise table.error(
            "direction", "expected one of [1, 0], [-1, 0], [0, 1], [0, -1]: x and y of the world"
        )
    phrases = table.phrases("phrases")
    if "" in phrases:
        raise table.error("phrases", "an action cannot be left unsaid: remove the empty string")
    table.no_other_keys()
    return Action(name, place, direction, phrases)


def _grammar(table: Table) -> GrammarWords:
    grammar = GrammarWords(
        openings=table.phrases("openings"),
        verbs=table.phrases("verbs"),
        nouns=table.phrases("nouns"),
        descriptions=table.templates("descriptions", required=("values",), optional=("noun",)),
        commands=_commands(table),
        connectives=table.phrases("connectives"),
        order_words=table.optional_phrases("order_words"),
    )
    for key in ("verbs", "nouns"):
        if "" in getattr(grammar, key):
            raise table.error(key, "an empty word would let two descriptions run together")
    for word in grammar.order_words:
        if word not in grammar.openings or " " in word or not word:
            raise table.error("order_words", f"expected openings of one word, got {word!r}")
    table.no_other_keys()
    return grammar


def _commands(table: Table) -> tuple[str, ...]:
    commands = table.templates(
        "commands", required=("verb", "moved", "relation", "reference"), optional=("opening",)
    )
    for template in commands:
        fields = [word for word in template.split() if word != "{opening}"]
        if abs(fields.index("{moved}") - fields.index("{reference}")) == 1:
            raise table.error("commands", f"no word between the two objects in {template!r}")
        if fields[0] in ("{moved}", "{reference}"):
            raise table.error("commands", f"a command cannot begin with an object: {template!r}")
    return commands


def _held_out(table: Table, actions: Sequence[Action]) -> HeldOut:
    named = table.table("phrases")
    phrases = {action.name: named.phrases(action.name) for action in actions}
    named.no_other_keys()
    held_out = HeldOut(_commands(table), phrases)
    table.no_other_keys()
    return held_out


def _check_names(root: Table, domain: Domain) -> None:
    for key, named in (
        ("attribute", domain.attributes),
        ("attribute.values", domain.concepts),
        ("action", domain.actions),
    ):
        names = [item.name for item in named]
        for name in names:
            if names.count(name) > 1:
                raise root.error(key, f"the name {name!r} is given twice")
    if len(domain.attributes) > MAX_ATTRIBUTES:
        raise root.error(
            "attribute", f"at most {MAX_ATTRIBUTES} types, got {len(domain.attributes)}"
        )
    if len(domain.concepts) > MAX_CONCEPTS:
        raise root.error(
            "attribute.values", f"at most {MAX_CONCEPTS} in all, got {len(domain.concepts)}"
        )


def _check_appearance(root: Table, domain: Domain) -> None:
    """One attribute type says the colour, one the edges, at most one the studs."""
    for key in ("rgb", "edges_m", "studs"):
        types = {value.attribute for value in domain.concepts if getattr(value, key) is not None}
        if len(types) > 1:
            raise root.error(key, f"given by more than one attribute type: {sorted(types)}")
        if key == "studs":
            continue
        if not types:
            raise root.error(key, "no attribute type gives it, but every block needs it")
        for value in domain.attribute(types.pop()).values:
            if getattr(value, key) is None:
                raise root.error(f"{value.attribute}.{value.name}", f"{key} is missing")


def _check_words(root: Table, domain: Domain) -> None:
    seen: dict[str, str] = {}
    for value in domain.concepts:
        for word in value.words:
            if word in seen:
                raise root.error(
                    f"{value.attribute}.{value.name}.words",
                    f"{word!r} already names {seen[word]!r}",
                )
            seen[word] = value.name
    for word in sorted(_grammar_words(domain.grammar, domain.actions) & seen.keys()):
        raise root.error(
            "grammar", f"{word!r} names the concept {seen[word]!r} and cannot be another word too"
        )


def _check_held_out(root: Table, domain: Domain) -> None:
    """Nothing of it may stand in the grammar, and no word may be a new one."""
    if domain.held_out is None:
        return
    known = {*domain.vocabulary(), *domain.lexicon()}
    said = {*domain.grammar.commands, *(p for a in domain.actions for p in a.phrases)}
    held_out = domain.held_out
    for text in (*held_out.commands, *(p for each in held_out.phrases.values() for p in each)):
        if text in said:
            raise root.error("held_out", f"{text!r} is no new wording: training has it")
        for word in text.split():
            if not word.startswith("{") and word not in known:
                raise root.error("held_out", f"{word!r} in {text!r} is a word of no other wording")


def _grammar_words(grammar: GrammarWords, actions: Iterable[Action]) -> set[str]:
    texts = [
        *grammar.openings,
        *grammar.verbs,
        *grammar.nouns,
        *grammar.descriptions,
        *grammar.commands,
        *grammar.connectives,
        *(phrase for action in actions for phrase in action.phrases),
    ]
    return {word for text in texts for word in text.split() if not word.startswith("{")}


def _named(items: Iterable[Any], name: str) -> Any:
    for item in items:
        if item.name == name:
            return item
    raise KeyError(name)


def _three(numbers: tuple[float, ...] | None) -> tuple[float, float, float] | None:
    return None if numbers is None else (numbers[0], numbers[1], numbers[2])


def _two(numbers: tuple[int, ...] | None) -> tuple[int, int] | None:
    return None if numbers is None else (numbers[0], numbers[1])
