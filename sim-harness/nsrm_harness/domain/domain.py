"""Reads domains: the concepts, the actions, and their words (Table I).

A domain is one TOML file, which may extend another one. Everything that depends on it is derived
from it: episodes, the network's dimensions, the model file, the static arrays, the docs.

* Concepts are the values of all attribute types, in the file's order.
* The lexicon has the words that name a concept. The vocabulary has the group token, which stands
  for a run of words for concepts and extremes, and then all other words that the grammar can
  produce.

The types below define what a file may contain; :mod:`nsrm_harness.domain.reader` reads it and
checks the rules that span several tables.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo

from nsrm_harness.common.toml_file import NO_OTHER_KEYS, Derived, Number, Whole
from nsrm_harness.domain.compounds import Compound, Compounds
from nsrm_harness.domain.distances import Distances
from nsrm_harness.domain.ordinals import Ordinals
from nsrm_harness.domain.program import ALL, BOTH, SIZE_EXTREMES, TABLE
from nsrm_harness.domain.rewriting import (
    Apart,
    Arrangements,
    Exceptions,
    Lists,
    Perspectives,
    Repairs,
    SequenceWords,
    Simplification,
    Table,
)
from nsrm_harness.domain.wording import (
    Alternatives,
    Commands,
    ConceptWords,
    Descriptions,
    Identifier,
    Phrase,
    Phrases,
    Relations,
    Texts,
    Words,
)

#: Stands for a run of concept words, ``[[X]]`` in section IV-B; row 0 of embeddings.
GROUP_TOKEN = "[[X]]"

View = Literal["color", "brightness"]
Place = Literal["on", "beside"]
Channel = Annotated[Number, Field(ge=0.0, le=1.0)]
Edge = Annotated[Number, Field(ge=0.01, le=0.2)]
Studs = Annotated[Whole, Field(ge=1, le=8)]
Component = Annotated[Number, Field(ge=-1.0, le=1.0)]


def _direction(
    direction: tuple[float, float] | None, info: ValidationInfo
) -> tuple[float, float] | None:
    place = info.data.get("place")
    if place == "on" and direction is not None:
        raise ValueError('only an action with place = "beside" has one')
    if place == "beside" and (direction is None or sorted(map(abs, direction)) != [0.0, 1.0]):
        raise ValueError(
            "expected one of [1, 0], [-1, 0], [0, 1], [0, -1]: x and y of the world, got "
            f"{None if direction is None else list(direction)}"
        )
    return direction


def _order_words(words: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
    for word in words:
        if word not in info.data.get("openings", words) or " " in word or not word:
            raise ValueError(f"expected openings with one word, got {word!r}")
    return words


def _not_null(given: Any) -> Any:
    if given is None:
        raise ValueError("expected a table, got None")
    return given


@dataclass(frozen=True)
class Value:
    """One value of an attribute type: a concept."""

    __pydantic_config__ = NO_OTHER_KEYS

    name: Identifier
    #: Name of its attribute type.
    attribute: Derived
    #: Its words in sentences; single words in lower case.
    words: ConceptWords
    #: Colour of a block that has this value, each channel in 0..1.
    rgb: tuple[Channel, Channel, Channel] | None = None
    #: Length of such a block along its x, y and z axes, metres.
    edges_m: tuple[Edge, Edge, Edge] | None = None
    #: Rows (along x) and columns (along y) of studs on its top face.
    studs: tuple[Studs, Studs] | None = None


@dataclass(frozen=True)
class Attribute:
    """An attribute type with its values."""

    __pydantic_config__ = NO_OTHER_KEYS

    name: Identifier
    #: What its operator sees of a crop.
    view: View
    values: Annotated[tuple[Value, ...], Field(min_length=2)]


@dataclass(frozen=True)
class Action:
    """A way to place an object relative to another one."""

    __pydantic_config__ = NO_OTHER_KEYS

    name: Identifier
    place: Place
    #: For ``beside``: unit vector (x, y) along one of the world's axes.
    direction: Annotated[
        tuple[Component, Component] | None,
        Field(default=None, validate_default=True),
        AfterValidator(_direction),
    ]
    #: Its words in sentences, between the two objects.
    phrases: Relations


@dataclass(frozen=True)
class GrammarWords:
    """The words of commands. An empty string means that the part is optional."""

    __pydantic_config__ = NO_OTHER_KEYS

    openings: Phrases
    verbs: Words
    nouns: Words
    descriptions: Descriptions
    commands: Commands
    connectives: Phrases
    #: One-word openings that have another meaning anywhere but at the start of a sentence.
    order_words: Annotated[Phrases, AfterValidator(_order_words)] = ()


@dataclass(frozen=True)
class HeldOut:
    """Wordings that are held out from training, made of words that are in it."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Templates like the grammar's.
    commands: Commands
    #: Phrases of each action, by its name.
    phrases: Mapping[str, Phrases]


#: The rules that everyday wording must have.
NEEDED_RULES = (
    "starting",
    "listing",
    "before",
    "command",
    "after",
    "next",
    "please",
    "order",
    "description",
    "possessor",
)
#: Rules of descriptions of several objects, if the domain has words for them: without and with a
#: relation.
SEVERAL_RULES = ("several", "several_related")
#: Rules of descriptions with a relation, if some action's state has a rule.
RELATING_RULES = ("related", "undescribed")
#: Keys of a relation that name rules. The last two name further alternatives of `RELATING_RULES`.
RULE_NAMES = ("rule", "state", *RELATING_RULES)


@dataclass(frozen=True)
class EverydayWords:
    """How people say commands: see ``everyday.toml`` and :mod:`nsrm_harness.domain.everyday`."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: For each action, by its name: the rule of its relations under ``rule``, the rule of the state
    #: that it brings about under ``state``, and what the placeholders in these rules stand for.
    #: The `SUPERLATIVES` have no ``rule``.
    relations: Mapping[str, Mapping[str, Phrase]]
    #: The alternatives of each rule.
    rules: Annotated[Mapping[Identifier, Alternatives], Field(min_length=1)]

    def used_rules(self) -> dict[str, Texts]:
        """The rules that sentences about the domain's actions use."""
        used: set[str] = set()
        named = [relation.get(key) for relation in self.relations.values() for key in RULE_NAMES]
        relating = RELATING_RULES if self.states() else ()
        left = {*NEEDED_RULES, *relating, *SEVERAL_RULES, *named}
        while left := (left & self.rules.keys()) - used:
            used |= left
            texts = [text for name in left for text in self.rules[name]]
            left = {word.strip("{}") for text in texts for word in text.split()}
        return {name: texts for name, texts in self.rules.items() if name in used}

    def placements(self) -> dict[str, Mapping[str, Phrase]]:
        """The relations that say where to: those of actions."""
        return {name: each for name, each in self.relations.items() if "rule" in each}

    def own_texts(self, name: str, rule: str) -> Texts:
        """The further alternatives that a relation has of one of `RELATING_RULES`. There
        ``{reference}`` is the other object."""
        return self.rules.get(self.relations.get(name, {}).get(rule, ""), ())

    def states(self) -> dict[str, Mapping[str, Phrase]]:
        """The relations that descriptions may have."""
        return {name: each for name, each in self.relations.items() if "state" in each}


@dataclass(frozen=True)
class SeveralWords:
    """How several objects are said that are moved: "all of the red blocks"."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words for all that fit, before a plural, "all",
    all: ConceptWords
    #: before a singular, "every",
    every: ConceptWords
    #: and for both of two.
    both: ConceptWords
    #: Words that may stand between these and the rest: "of", "the".
    between: tuple[Phrase, ...]
    #: Words in the plural, each with its singular, as which it is read: "blocks", "them".
    #: Elsewhere, they are other words, or unknown.
    plurals: Mapping[Phrase, Phrase]
    #: Words for all objects, without a noun, "everything",
    alone: tuple[Phrase, ...] = ()
    #: and numbers that mean both behind an article, "two".
    numbers: tuple[Phrase, ...] = ()

    def quantifiers(self) -> dict[str, tuple[str, ...]]:
        """The words that stand before those for several objects, by what they mean in programs."""
        return {ALL: (*self.all, *self.every), BOTH: self.both}


@dataclass(frozen=True)
class SpellingWords:
    """What unknown words are read as, if the sentence then makes sense."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words that dictation writes for known ones, each with that one.
    heard: Mapping[Phrase, Phrase]
    #: Words that are near known ones and mean something else: they are never taken for misspelt.
    other_words: tuple[Phrase, ...]
    #: Language whose dictionary has further ones, for :mod:`nsrm_harness.domain.dictionary`.
    language: Literal["de", "en", "es", "fr", "it", "nl", "pt"] | None = None


@dataclass(frozen=True)
class Domain:
    """A checked domain file."""

    __pydantic_config__ = NO_OTHER_KEYS

    name: Identifier
    attributes: Annotated[tuple[Attribute, ...], Field(alias="attribute", min_length=1)]
    actions: Annotated[tuple[Action, ...], Field(alias="action", min_length=1)]
    grammar: GrammarWords
    #: Words for which one of several objects is meant, "leftmost": by the action in whose direction
    #: it lies farthest, and by `SIZE_EXTREMES`.
    extremes: Annotated[Mapping[Identifier, ConceptWords], Field(default_factory=dict)]
    #: Words that may stand for what the step before moved, "it", each with the word that is then
    #: read behind it: "one's" for "its", or an empty text.
    pronouns: Annotated[Mapping[Phrase, Phrase], Field(default_factory=dict)]
    #: Words that put an object somewhere and never only take it: behind a whole step of one of
    #: them, a pronoun behind one is of another step.
    placing: Annotated[tuple[Phrase, ...], Field(default_factory=tuple)]
    #: What a pronoun is a word like any other behind: "so that" in "so that it is".
    conjunctions: Annotated[tuple[Phrase, ...], Field(default_factory=tuple)]
    several: Annotated[SeveralWords | None, Field(default=None), BeforeValidator(_not_null)]
    #: Phrases that are read as others.
    rephrasing: Annotated[Mapping[Phrase, Phrase], Field(default_factory=dict)]
    simplification: Annotated[
        Simplification | None, Field(default=None), BeforeValidator(_not_null)
    ]
    #: How objects are left out of a description.
    exceptions: Annotated[Exceptions | None, Field(default=None), BeforeValidator(_not_null)]
    #: Whose left is meant.
    perspectives: Annotated[Perspectives | None, Field(default=None), BeforeValidator(_not_null)]
    #: How several objects are listed that are moved.
    lists: Annotated[Lists | None, Field(default=None), BeforeValidator(_not_null)]
    repairs: Annotated[Repairs | None, Field(default=None), BeforeValidator(_not_null)]
    #: In which order steps are carried out that are said in another one.
    sequence: Annotated[SequenceWords | None, Field(default=None), BeforeValidator(_not_null)]
    #: How far from the reference an object is put.
    distances: Annotated[Distances | None, Field(default=None), BeforeValidator(_not_null)]
    apart: Annotated[Apart | None, Field(default=None), BeforeValidator(_not_null)]
    ordinals: Annotated[Ordinals | None, Field(default=None), BeforeValidator(_not_null)]
    arrangements: Annotated[Arrangements | None, Field(default=None), BeforeValidator(_not_null)]
    table: Annotated[Table | None, Field(default=None), BeforeValidator(_not_null)]
    #: Actions that are made of others.
    compounds: Annotated[Compounds | None, Field(default=None), BeforeValidator(_not_null)]
    held_out: Annotated[HeldOut | None, Field(default=None), BeforeValidator(_not_null)]
    everyday: Annotated[EverydayWords | None, Field(default=None), BeforeValidator(_not_null)]
    spelling: Annotated[SpellingWords | None, Field(default=None), BeforeValidator(_not_null)]
    #: The text of :meth:`as_json`, kept so that the content of the file is passed on unchanged.
    document: Derived

    @cached_property
    def concepts(self) -> tuple[Value, ...]:
        """The values of all attribute types, in order."""
        return tuple(value for attribute in self.attributes for value in attribute.values)

    def attribute(self, name: str) -> Attribute:
        """The attribute type with this name; ``KeyError`` if there is none."""
        return _named(self.attributes, name)

    def concept(self, name: str) -> Value:
        """The attribute value with this name; ``KeyError`` if there is none."""
        return _named(self.concepts, name)

    def action(self, name: str) -> Action:
        """The action with this name; ``KeyError`` if there is none."""
        return _named(self.actions, name)

    def compound(self, name: str) -> Compound | None:
        """The compound with this name; nothing for an action."""
        made = self.compounds.made if self.compounds is not None else ()
        return next((each for each in made if each.name == name), None)

    def lexicon(self) -> dict[str, int]:
        """Words that name a concept, sorted, each with the concept's index."""
        words = {word: index for index, value in enumerate(self.concepts) for word in value.words}
        return dict(sorted(words.items()))

    def extreme_words(self) -> dict[str, tuple[str, ...]]:
        """The names of the extremes, as in programs, each with its words. An action's is named by
        its first word, and the others by their own name."""
        return {
            key.lower() if key in SIZE_EXTREMES else words[0]: words
            for key, words in self.extremes.items()
        }

    def ranked(self) -> dict[str, tuple[str, int]]:
        """The names of what is counted, "second leftmost", each with the name of the extreme and
        the number."""
        counts = self.ordinals.counts if self.ordinals is not None else ()
        return {
            f"{words[0]} {extreme[0]}": (name, rank)
            for name, extreme in self.extremes.items()
            for rank, words in enumerate(counts, 1)
            if rank > 1
        }

    def quantifier_words(self) -> dict[str, tuple[str, ...]]:
        """The words for several objects that are moved, by what they mean in programs."""
        several = self.several
        if several is None:
            return {}
        words, further = several.quantifiers(), {ALL: several.alone, BOTH: several.numbers}
        return {name: (*each, *further[name]) for name, each in words.items()}

    def table_words(self) -> dict[str, tuple[str, ...]]:
        """The words for the table, by its name in programs."""
        return {TABLE: self.table.words} if self.table is not None else {}

    def group_words(self) -> set[str]:
        """The words for which a group token stands: those of concepts, of extremes, for several
        objects, and for the table."""
        choices = (
            *self.extremes.values(),
            *self.quantifier_words().values(),
            *self.table_words().values(),
        )
        return {*self.lexicon(), *(word for words in choices for word in words)}

    def vocabulary(self) -> list[str]:
        """The group token, then every other token that the grammar produces, sorted."""
        return [GROUP_TOKEN, *sorted(self.other_words())]

    def other_words(self) -> set[str]:
        """All words of the grammar that no group token stands for."""
        grammar = self.grammar
        texts = [
            *grammar.openings,
            *grammar.verbs,
            *grammar.nouns,
            *grammar.descriptions,
            *grammar.commands,
            *grammar.connectives,
            *(phrase for action in self.actions for phrase in action.phrases),
        ]
        if self.everyday is not None:
            texts += [text for rule in self.everyday.used_rules().values() for text in rule]
            texts += [
                text
                for relation in self.everyday.relations.values()
                for name, text in relation.items()
                if name not in RULE_NAMES
            ]
        return {word for text in texts for word in text.split() if not word.startswith("{")}

    def known_words(self) -> set[str]:
        """All words of its sentences."""
        return {*self.group_words(), *self.other_words()}

    def as_json(self) -> str:
        """The whole file as JSON, keys in the file's order; it goes into the model file."""
        return self.document


def _named(items: Iterable[Any], name: str) -> Any:
    for item in items:
        if item.name == name:
            return item
    raise KeyError(name)
