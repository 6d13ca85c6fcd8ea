"""Everyday wording: generates commands as people say them.

The rules are those of a domain's ``everyday`` table; ``everyday.toml`` describes them. They contain
no recursion, so they have finitely many sentences, and every one of them is recognised
(`recogniser`).
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from nsrm_harness.common.errors import DomainError
from nsrm_harness.common.toml_file import read_toml
from nsrm_harness.domain.compounds import Compound, compounds_of
from nsrm_harness.domain.distances import distances_of
from nsrm_harness.domain.domain import (
    GROUP_TOKEN,
    RELATING_RULES,
    SEVERAL_RULES,
    Domain,
    EverydayWords,
)
from nsrm_harness.domain.ordinals import ordinals_of
from nsrm_harness.domain.program import ALL, BOTH, SIZE_EXTREMES, TABLE, Program, Relation, Step
from nsrm_harness.domain.reader import COUNTING, parse
from nsrm_harness.domain.rewriting import (
    PHRASES,
    exceptions_of,
    expanded,
    perspectives_of,
    repairs_of,
    rephrasing_of,
    sequence_of,
    simplification_of,
    with_sides,
)

#: The wording of the paper's domain.
EVERYDAY = Path(__file__).resolve().parent / "everyday.toml"
#: Share of sentences whose steps are listed, and of those that begin with an order word.
LISTED, STARTED = 0.08, 0.1

_FIELD = re.compile(r"\{(#?[a-z_]+)\}")
#: In place of the concepts of a description: it is said by a pronoun.
PRONOUN = "[[it]]"
#: Tables of a wording file that are not part of the everyday wording itself, beside `spelling`.
TABLES = (
    "synonyms", "extremes", "pronouns", "several", "rephrasing", "simplification", "exceptions",
    "lists", "repairs", "sequence", "distances", "apart", "ordinals", "arrangements", "table",
    "compounds", "perspectives",
)  # fmt: skip
#: What a description may be of.
DESCRIBED = ("moved", "reference", "possessor")


def with_everyday(domain: Domain, path: Path = EVERYDAY) -> Domain:
    """The domain with the everyday wording of a file, without what only actions use that the domain
    does not have. Raises ``DomainError`` with the problem."""
    words = read_toml(path, DomainError, "everyday wording")
    document = _document(domain)
    verbs = {key: words.pop(key) for key in ("placing", "conjunctions") if key in words}
    (
        synonyms, extremes, pronouns, several, rephrasing, simplification, exceptions, lists,
        repairs, sequence, distances, apart, ordinals, arrangements, table, compounds,
        perspectives,
    ) = (_taken_out(words, name, path) for name in TABLES)  # fmt: skip
    values = {value["name"]: value for each in document["attribute"] for value in each["values"]}
    for name, added in synonyms.items():
        if name not in values:
            raise DomainError(
                f"{path}: synonyms.{name}: unknown attribute value; expected some of: "
                f"{', '.join(values)}"
            )
        known = values[name]["words"]
        values[name]["words"] = [*known, *(word for word in added if word not in known)]
    names = [*(action["name"] for action in document["action"]), *SIZE_EXTREMES]
    if extremes := {name: extremes[name] for name in names if name in extremes}:
        document["extremes"] = extremes
    if pronouns:
        document["pronouns"] = pronouns
    document |= verbs
    if several:
        document["several"] = several
    if exceptions := exceptions_of(exceptions, str(path)):
        document["exceptions"] = exceptions
    if lists:
        document["lists"] = lists
    if perspectives := perspectives_of(perspectives, names, str(path)):
        document["perspectives"] = perspectives
    if repairs := repairs_of(repairs, str(path)):
        document["repairs"] = repairs
    if sequence := sequence_of(sequence, str(path)):
        document["sequence"] = sequence
    if apart:
        document["apart"] = apart
    nouns = words["rules"].get("noun", ())
    if ordinals := ordinals_of(ordinals, extremes, nouns, str(path)):
        document["ordinals"] = ordinals
    if arrangements := expanded(arrangements, names, words["rules"], str(path)):
        document["arrangements"] = arrangements
    if table := with_sides(table, names):
        document["table"] = table
    if distances := distances_of(distances, names, str(path)):
        document["distances"] = distances
    if compounds := compounds_of(compounds, names, str(path)):
        document["compounds"] = compounds
    if spelling := words.pop("spelling", None):
        document["spelling"] = spelling
    document["everyday"] = words
    described = words.get("relations", {})
    without = parse(document, str(path))
    checked = everyday_of(without)
    words["relations"] = dict(checked.relations)
    words["rules"] = checked.used_rules()
    # "Behind" is no word of a domain in which nothing is put there.
    missing = _words_of(described, {*described} - {*checked.relations}) - without.other_words()
    if phrases := rephrasing_of(rephrasing, str(path)):
        document["rephrasing"] = _read_as_known(phrases, missing)
    if simpler := simplification_of(simplification, str(path)):
        document["simplification"] = {
            key: _read_as_known(phrases, missing) if key in PHRASES else phrases
            for key, phrases in simpler.items()
        }
    return parse(document, str(path))


def _read_as_known(phrases: Mapping[str, str], missing: set[str]) -> dict[str, str]:
    """The phrases that are not read as words which are missing."""
    return {text: read_as for text, read_as in phrases.items() if not {*read_as.split()} & missing}


def _words_of(relations: Mapping[str, Mapping[str, str]], names: Iterable[str]) -> set[str]:
    """The words of these relations of a wording file."""
    return {word for name in names for text in relations[name].values() for word in text.split()}


def _taken_out(words: dict[str, Any], name: str, path: Path) -> dict[str, Any]:
    """A table of a wording file that is not part of the everyday wording itself."""
    table = words.pop(name, {})
    if not isinstance(table, dict):
        raise DomainError(f"{path}: {name}: expected a table, got {table!r}")
    return table


def without_states(domain: Domain) -> Domain:
    """The domain with everyday wording in which descriptions have no relations."""
    words = everyday_of(domain)
    relations = {
        name: {key: text for key, text in relation.items() if key != "state"}
        for name, relation in words.relations.items()
    }
    return replace(domain, everyday=replace(words, relations=relations))


def _document(domain: Domain) -> dict[str, Any]:
    return json.loads(domain.as_json())


class Speaker:
    """Says programs of one domain in everyday wording."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        self._words = everyday_of(domain)
        self._domain = domain
        self._ranked = domain.ranked()
        self._lexicon = {*domain.group_words(), GROUP_TOKEN}
        self._rng = rng

    def sentence(self, program: Program) -> list[str]:
        """The words of a random wording of `program`."""
        return [word for step in self.steps(program) for word in step]

    def steps(self, program: Program) -> list[list[str]]:
        """The words of each step in a random wording of `program`."""
        listing = None
        if self._rng.random() < LISTED:
            listing = self._choose(self._words.rules["listing"])
        steps: list[list[str]] = []
        for index, step in enumerate(program):
            lead = listing
            if lead is None and index > 0:
                lead = "{next}"
            elif lead is None:
                lead = "{starting}" if self._rng.random() < STARTED else ""
            steps.append(self.step(step, index, lead, behind=steps[-1] if steps else ()))
        return steps

    def step(
        self, step: Step | None, index: int, lead: str = "", behind: Sequence[str] = ()
    ) -> list[str]:
        """The words of a random wording of one step.

        * `step`: without one, its action is random and its descriptions are group tokens; a group
          token or `PRONOUN` may also stand in place of the concepts of a step
        * `lead`: the alternative that joins it to the previous step
        * `behind`: the words before it
        """
        return self.words(f"{lead} {{before}} {{command}} {{after}}", step, index, behind)

    def words(
        self,
        text: str,
        step: Step | None = None,
        index: int = 0,
        behind: Sequence[str] = (),
    ) -> list[str]:
        """Random words for an alternative of a rule, in which no description follows another one
        directly, for both would be read as one, and no tower is built beside another object, which
        no step means."""
        lists = self._domain.lists if step is not None and step.object_which is not None else None
        while True:
            try:
                parts = list(self._expanded(text, _Context.of(step, index)))
            except _CannotBeSaidError:
                continue
            ends_described = bool(behind) and behind[-1] in self._lexicon
            described = [ends_described, *(isinstance(part, tuple) for part in parts)]
            if any(pair == (True, True) for pair in pairwise(described)):
                continue
            words = [word for part in parts for word in ([part] if isinstance(part, str) else part)]
            if lists is not None and lists.is_tower_aside(words):
                continue
            return words

    def _expanded(self, text: str, context: _Context) -> Iterator[str | tuple[str, ...]]:
        """The words, with those of a description's values together."""
        for word in text.split():
            found = _FIELD.fullmatch(word)
            if found is None:
                yield word
                continue
            name = found.group(1)
            if name in COUNTING:
                yield self._words.rules[name][context.index]
            elif name == "values":
                yield self._values(context.saying)
            elif name == "nouns":
                yield self._noun(context.saying)
            elif name == "relation" and (compound := self._compound(context.action)):
                yield from self._compounded(compound, context)
            elif name == "relation":
                relation = self._words.relations[context.action or self._any_action()]
                filled = self._choose(self._words.rules[relation["rule"]])
                yield from self._expanded(filled_in(filled, relation), context)
            elif name == "relating" and (
                compound := self._compound(context.saying.relations[0].name)
            ):
                said = f"{self._choose(compound.said)} {{reference}}"
                yield from self._expanded(said, context.of_anchor())
            elif name == "relating":
                state = self._words.relations[context.saying.relations[0].name]
                filled = self._choose(self._words.rules[state["state"]])
                yield from self._expanded(filled_in(filled, state), context.of_anchor())
            elif name in DESCRIBED:
                said = context.moved if name == "moved" else context.reference
                if said.which in (ALL, BOTH):
                    said = self._quantified(said)
                yield from self._described(name, said, replace(context, saying=said))
            else:
                yield from self._expanded(self._choose(self._words.rules[name]), context)

    def _compounded(self, compound: Compound, context: _Context) -> Iterator[str | tuple[str, ...]]:
        yield from self._choose(compound.said).split()
        if not compound.between or not context.reference.relations:
            yield from self._expanded("{reference}", context)
            return
        # One of other words is not told from what follows.
        two = (context.reference.concepts, context.reference.relations[0].to)
        for index, concepts in enumerate(two):
            said = self._choose(["the {values} block", "the {values} one", "the {values}"])
            yield from self._expanded(said, replace(context, saying=_Said(concepts)))
            if index == 0:
                yield "and"

    def _described(
        self, name: str, said: _Said, context: _Context
    ) -> Iterator[str | tuple[str, ...]]:
        if PRONOUN in said.concepts:
            # As values, so that no description follows: "that red" is one.
            yield (self._pronoun(is_owner=name == "possessor"),)
            return
        if said.which == TABLE:
            if name == "possessor":
                raise _CannotBeSaidError
            yield self._choose(("the", "the", "the", "this"))
            yield self._table()
            return
        if said.which in self._ranked:
            yield from self._expanded(self._counted(name, said), context)
            return
        rule = _description_rule(name, said)
        texts, own = self._words.rules[rule], ()
        if rule in RELATING_RULES:
            own = self._words.own_texts(said.relations[0].name, rule)
        at = int(self._rng.integers(len(texts) + len(own)))
        if at < len(texts):
            yield from self._expanded(texts[at], context)
        else:
            state = self._words.relations[said.relations[0].name]
            chosen = filled_in(own[at - len(texts)], state)
            yield from self._expanded(chosen, context.of_anchor())

    def _values(self, description: _Said) -> tuple[str, ...]:
        said = [
            name if name == GROUP_TOKEN else self._choose(self._domain.concept(name).words)
            for name in description.concepts
        ]
        values = tuple(said[index] for index in self._rng.permutation(len(said)))
        if description.which is None:
            return values
        if description.which in self._ranked:
            return values
        if description.quantifier is not None:
            return (*description.quantifier, *values)
        return (self._choose(self._domain.extreme_words()[description.which]), *values)

    def _counted(self, name: str, description: _Said) -> str:
        """Words for what is counted: "the second {values} {noun} from the left"."""
        ordinals = self._domain.ordinals
        if ordinals is None or description.relations or name == "possessor":
            raise _CannotBeSaidError
        extreme, rank = self._ranked[description.which or ""]
        count, the = self._choose(ordinals.counts[rank - 1]), self._choose(ordinals.articles)
        word = self._choose(self._domain.extremes[extreme])
        texts = [f"{the} {count} {word} {{noun}}"]
        if description.concepts:
            texts = [
                f"{the} {count} {word} {{values}} {{noun}}",
                f"{the} {count} {word} {{values}}",
            ]
        if starts := ordinals.texts_of(extreme):
            start = self._choose(starts)
            texts = [
                *texts,
                f"{the} {count} {{noun}} {start}",
                f"{the} {{noun}} {count} {start}",
                f"{the} {{noun}} that is {count} {start}",
                f"{the} {count} one {start}",
                f"{the} {count} {start}",
            ]
            if description.concepts:
                texts = [
                    *texts[:2],
                    *[f"{the} {count} {{values}} {{noun}} {start}"] * 3,
                    f"{the} {count} {{values}} {start}",
                    f"{the} {{values}} {{noun}} {count} {start}",
                    f"{the} {{values}} {{noun}} that is {count} {start}",
                ]
        return self._choose(texts)

    def _quantified(self, description: _Said) -> _Said:
        """The description with words for several objects: "all of the"."""
        several = self._domain.several
        if several is None:
            raise _CannotBeSaidError
        word = self._choose(several.quantifiers()[description.which or ALL])
        between = ((), ("the",), ("of", "the"))[int(self._rng.integers(3))]
        if word in several.every or not {*between} <= {*several.between}:
            between = ()
        return replace(description, quantifier=(word, *between))

    def _table(self) -> tuple[str, ...]:
        if self._domain.table is None:
            raise _CannotBeSaidError
        return (self._choose(self._domain.table.words),)

    def _noun(self, description: _Said) -> str:
        """A noun for several objects: in the singular behind "every"."""
        several = self._domain.several
        if several is None or description.quantifier is None:
            raise _CannotBeSaidError
        nouns = self._words.rules["noun"]
        plural = self._choose([each for each, one in several.plurals.items() if one in nouns])
        is_single = description.quantifier[0] in several.every
        return several.plurals[plural] if is_single else plural

    def _pronoun(self, is_owner: bool) -> str:
        pronouns = self._domain.pronouns
        fitting = [word for word, owner in pronouns.items() if bool(owner) == is_owner]
        if not fitting:
            raise _CannotBeSaidError
        return self._choose(fitting)

    def _compound(self, name: str | None) -> Compound | None:
        return None if name is None else self._domain.compound(name)

    def _any_action(self) -> str:
        return self._choose(list(self._words.placements()))

    def _choose(self, texts: Sequence[str]) -> str:
        return texts[int(self._rng.integers(len(texts)))]


@dataclass(frozen=True)
class _Said:
    """The description of an object."""

    concepts: tuple[str, ...]
    relations: tuple[Relation, ...] = ()
    which: str | None = None
    #: The words for several objects, if it is of several.
    quantifier: tuple[str, ...] | None = None


_UNKNOWN = _Said((GROUP_TOKEN,))


@dataclass(frozen=True)
class _Context:
    """What the words of one step depend on."""

    #: Index of the step.
    index: int
    #: Without one, every relation is a random action's.
    action: str | None = None
    moved: _Said = _UNKNOWN
    #: Of the step, or of the relation that is being said.
    reference: _Said = _UNKNOWN
    #: The description that is being said.
    saying: _Said = _UNKNOWN

    def of_anchor(self) -> _Context:
        """What the words of the relation of what is being said depend on."""
        first, *others = self.saying.relations
        return replace(self, reference=_Said(first.to, tuple(others), first.which))

    @classmethod
    def of(cls, step: Step | None, index: int) -> _Context:
        if step is None:
            return cls(index)
        return cls(
            index,
            step.action,
            _Said(step.object, step.object_relations, step.object_which),
            _Said(step.reference, step.reference_relations, step.reference_which),
        )


class _CannotBeSaidError(Exception):
    """A rule cannot say this description."""


def _description_rule(name: str, said: _Said) -> str:
    """The rule for a description."""
    if name == "possessor":
        if said.relations:
            raise _CannotBeSaidError
        return name
    if said.quantifier is not None:
        return SEVERAL_RULES[bool(said.relations)]
    if not said.concepts and said.which is None:
        return "undescribed"
    return "related" if said.relations else "description"


def state_texts(words: EverydayWords) -> list[str]:
    """The alternatives by which descriptions relate objects."""
    return [
        filled_in(text, state)
        for state in words.states().values()
        for text in words.rules[state["state"]]
    ]


def own_texts(words: EverydayWords, rule: str) -> list[str]:
    """The further alternatives of a rule that single relations have."""
    return [
        filled_in(text, state)
        for name, state in words.states().items()
        for text in words.own_texts(name, rule)
    ]


def everyday_of(domain: Domain) -> EverydayWords:
    """The everyday wording of a domain; ``DomainError`` if it has none."""
    if domain.everyday is None:
        raise DomainError(f"the domain {domain.name!r} has no everyday wording")
    return domain.everyday


def filled_in(text: str, relation: Mapping[str, str]) -> str:
    """An alternative with what a relation's placeholders stand for."""
    return _FIELD.sub(lambda found: relation.get(found.group(1), found.group()), text)
