"""Reads a domain file: checks its tables by their types, then the rules that span
several tables."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import DomainError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.toml_file import checked, read_toml, refusal
from nsrm_harness.domain.compounds import COMPOSED
from nsrm_harness.domain.domain import (
    NEEDED_RULES,
    RELATING_RULES,
    RULE_NAMES,
    SEVERAL_RULES,
    Attribute,
    Domain,
    EverydayWords,
)
from nsrm_harness.domain.program import SIZE_EXTREMES, SUPERLATIVES

#: The paper's domain.
DEFAULT = Path(__file__).resolve().parent / "tabletop.toml"
#: That of the built-in model.
FOUR_SIDES = DEFAULT.with_name("four_sides.toml")
#: Largest number of concepts that describe one object, a capacity of the core: a domain has no
#: more attribute types.
MAX_ATTRIBUTES = 4
#: Indices of concepts and actions are bytes in the core.
MAX_CONCEPTS = 255

#: Largest number of steps of a program, a capacity of the core.
MAX_STEPS = 8
#: Largest number of sides by which a free place on the table is found, a capacity of the core.
MAX_SIDES = 8
#: Rules with an alternative for each step.
COUNTING = ("number", "numbered", "ordinal")
#: What is filled in from the program, and the rules that it uses.
FILLED_IN = {
    "moved": ("description",),
    "reference": ("description",),
    "values": (),
    "nouns": (),
    "relation": (),
    "relating": (),
}
_FIELD = re.compile(r"\{([a-z_]+)\}")

Faults = Iterator[tuple[str, str]]
"""Dotted keys, each with its problem."""


def load(path: Path | str = DEFAULT) -> Domain:
    """Reads and checks a domain file. Raises ``DomainError`` with file, key and problem."""
    return parse(_read(Path(path), ()), str(path))


def _read(path: Path, extended_by: tuple[Path, ...]) -> dict[str, Any]:
    """The content of a file, added to that of the file that it extends, if there is one."""
    content = read_toml(path, DomainError, "domain file")
    if "extends" not in content:
        return content
    extended, chain = content.pop("extends"), (*extended_by, path.resolve())
    if not isinstance(extended, str):
        raise DomainError(f"{path}: extends: expected the name of a file, got {extended!r}")
    if (path.parent / extended).resolve() in chain:
        raise DomainError(f"{path}: extends: {extended} extends this file")
    return _added(content, _read(path.parent / extended, chain))


def _added(more: Mapping[str, Any], content: Mapping[str, Any]) -> dict[str, Any]:
    """The content of a file with more: longer lists, larger tables, and other values."""
    every = dict(content)
    for key, value in more.items():
        there = content.get(key)
        if isinstance(value, list) and isinstance(there, list):
            every[key] = [*there, *value]
        elif isinstance(value, dict) and isinstance(there, dict):
            every[key] = _added(value, there)
        else:
            every[key] = value
    return every


def from_json(text: str, source: str) -> Domain:
    """The domain in an episode or model file; `source` names the file in errors."""
    try:
        document = json.loads(text)
    except ValueError as error:
        raise DomainError(f"{source}: the domain is not JSON: {error}") from error
    if not isinstance(document, dict):
        raise DomainError(f"{source}: the domain is not a JSON object")
    return parse(document, source)


def parse(document: Mapping[str, Any], source: str) -> Domain:
    """Checks a document read from TOML or JSON; `source` names it in errors."""
    read = checked(Domain, document, source, DomainError)
    domain = replace(
        read,
        attributes=tuple(map(_with_its_name, read.attributes)),
        document=json_text(document, ensure_ascii=False),
    )
    for check in (_names, _appearance, _held_out_actions, _everyday):
        if faults := list(check(domain)):
            raise refusal(source, faults, DomainError)
    domain = _with_its_relations(domain)
    for check in (
        _words, _held_out, _pronouns, _several, _rephrasing, _exceptions, _perspectives, _lists,
        _repairs, _sequence, _distances, _apart, _ordinals, _arrangements, _table, _compounds,
        _spelling,
    ):  # fmt: skip
        if faults := list(check(domain)):
            raise refusal(source, faults, DomainError)
    return domain


def _with_its_name(attribute: Attribute) -> Attribute:
    """The attribute type, with its name set in each of its values."""
    values = (replace(value, attribute=attribute.name) for value in attribute.values)
    return replace(attribute, values=tuple(values))


def _with_its_relations(domain: Domain) -> Domain:
    """The domain without the everyday relations of actions that it does not have; the superlatives
    stand behind the actions."""
    if domain.everyday is None:
        return domain
    every, names = domain.everyday.relations, [action.name for action in domain.actions]
    relations = {name: every[name] for name in (*names, *SUPERLATIVES) if name in every}
    return replace(domain, everyday=replace(domain.everyday, relations=relations))


def _names(domain: Domain) -> Faults:
    """Names are unique, and there are no more than the core can hold."""
    for key, named in (
        ("attribute", domain.attributes),
        ("attribute.values", domain.concepts),
        ("action", domain.actions),
    ):
        names = [item.name for item in named]
        for name in dict.fromkeys(names):
            if names.count(name) > 1:
                yield key, f"duplicate name {name!r}"
    for action in domain.actions:
        if action.name in SUPERLATIVES:
            yield "action", f"{action.name} is a relation of every domain: use another name"
    extremes = [*(action.name for action in domain.actions), *SIZE_EXTREMES]
    for name in domain.extremes:
        if name not in extremes:
            yield f"extremes.{name}", f"unknown; expected some of {', '.join(extremes)}"
    if len(domain.attributes) > MAX_ATTRIBUTES:
        yield "attribute", f"at most {MAX_ATTRIBUTES} types, got {len(domain.attributes)}"
    if len(domain.concepts) > MAX_CONCEPTS:
        yield "attribute.values", f"at most {MAX_CONCEPTS} in all, got {len(domain.concepts)}"


def _appearance(domain: Domain) -> Faults:
    """One attribute type defines the colour, one the edges, at most one the studs."""
    for key in ("rgb", "edges_m", "studs"):
        types = {value.attribute for value in domain.concepts if getattr(value, key) is not None}
        if len(types) > 1:
            yield key, f"defined by more than one attribute type: {sorted(types)}"
        elif key != "studs" and not types:
            yield key, "no attribute type defines it, but every block needs it"
        elif key != "studs":
            for value in domain.attribute(types.pop()).values:
                if getattr(value, key) is None:
                    yield f"{value.attribute}.{value.name}", f"{key} is missing"


def _words(domain: Domain) -> Faults:
    """Each word names one concept or one extreme, or says that several objects are meant."""
    named = [
        (f"{value.attribute}.{value.name}.words", f"the concept {value.name!r}", value.words)
        for value in domain.concepts
    ]
    named += [
        (f"extremes.{name}", f"the extreme {name}", words)
        for name, words in domain.extremes.items()
    ]
    named += [
        (f"several.{name}", f"several objects, {name!r}", words)
        for name, words in domain.quantifier_words().items()
    ]
    named += [("table.words", "the table", words) for words in domain.table_words().values()]
    seen: dict[str, str] = {}
    for key, what, words in named:
        for word in words:
            if word in seen:
                yield key, f"{word!r} already names {seen[word]}"
            seen.setdefault(word, what)
    quantifiers = {word for words in domain.quantifier_words().values() for word in words}
    for word in sorted((domain.other_words() & seen.keys()) - quantifiers):
        yield "grammar", f"{word!r} names {seen[word]} and cannot be another word, too"


def _held_out_actions(domain: Domain) -> Faults:
    """The held-out wordings have phrases for every action, and for no other."""
    if domain.held_out is None:
        return
    given, names = domain.held_out.phrases, [action.name for action in domain.actions]
    for name in names:
        if name not in given:
            yield f"held_out.phrases.{name}", "is missing"
    for name in given:
        if name not in names:
            yield f"held_out.phrases.{name}", f"unknown action; expected {', '.join(names)}"


def _held_out(domain: Domain) -> Faults:
    """The held-out wordings are not in the grammar and contain no new words."""
    if domain.held_out is None:
        return
    known = domain.known_words()
    said = {*domain.grammar.commands, *(p for a in domain.actions for p in a.phrases)}
    held_out = domain.held_out
    for text in (*held_out.commands, *(p for each in held_out.phrases.values() for p in each)):
        if text in said:
            yield "held_out", f"{text!r} is not held out: the grammar has it, too"
        for word in text.split():
            if not word.startswith("{") and word not in known:
                yield "held_out", f"{word!r} in {text!r} is not a word of the grammar"


def _everyday(domain: Domain) -> Faults:
    """Everyday wording has the rules that its reader needs, and they end."""
    if domain.everyday is None:
        return
    rules, names = domain.everyday.rules, [action.name for action in domain.actions]
    for name in NEEDED_RULES:
        if name not in rules:
            yield f"everyday.rules.{name}", "is missing"
    for name in COUNTING:
        if len(rules.get(name, ())) not in (0, MAX_STEPS):
            yield f"everyday.rules.{name}", f"expected {MAX_STEPS} alternatives, one for each step"
    yield from _everyday_relations(domain.everyday, names)
    if states := domain.everyday.states():
        for name in RELATING_RULES:
            if name not in rules:
                yield f"everyday.rules.{name}", "is missing: an action's state has a rule"
    for name in SEVERAL_RULES if domain.several is not None else ():
        if name not in rules:
            yield f"everyday.rules.{name}", "is missing: several objects can be said"
    placeholders = {
        name for relation in domain.everyday.relations.values() for name in relation
    } - {*RULE_NAMES}
    uses: dict[str, set[str]] = {}
    for name, texts in rules.items():
        if name in FILLED_IN or name in placeholders:
            yield f"everyday.rules.{name}", "has a meaning of its own: use another name"
        uses[name] = {found for text in texts for found in _FIELD.findall(text)}
        for used in sorted(uses[name] - rules.keys() - FILLED_IN.keys() - placeholders):
            yield f"everyday.rules.{name}", f"unknown rule {{{used}}}"
    for used, by in FILLED_IN.items():
        uses.setdefault(used, set(by))
    uses["relation"] = {each["rule"] for each in domain.everyday.placements().values()}
    uses["relating"] = {relation["state"] for relation in states.values()}
    if (looped := _loop(uses)) is not None:
        yield f"everyday.rules.{looped}", "contains itself"


def _everyday_relations(words: EverydayWords, actions: Sequence[str]) -> Faults:
    """Actions have a rule, superlatives a state alone, and what they name are rules."""
    for name in (*actions, *SUPERLATIVES):
        relation = words.relations.get(name)
        if relation is None:
            if name in actions:
                yield f"everyday.relations.{name}", "is missing"
            continue
        if name in SUPERLATIVES and "rule" in relation:
            yield f"everyday.relations.{name}.rule", "is no place: only descriptions have it"
        needed = "state" if name in SUPERLATIVES else "rule"
        for key in RULE_NAMES:
            if (rule := relation.get(key)) not in words.rules and (
                key == needed or rule is not None
            ):
                yield (
                    f"everyday.relations.{name}.{key}",
                    f"expected the name of a rule, got {rule!r}",
                )


def _pronouns(domain: Domain) -> Faults:
    """Pronouns, what is read behind them, and what puts an object somewhere are words that no group
    token stands for; one of the pronouns stands alone."""
    known = domain.other_words()
    if domain.pronouns and all(domain.pronouns.values()):
        yield "pronouns", "expected one that stands alone, with an empty text"
    for word, owner in domain.pronouns.items():
        for each in (word, owner) if owner else (word,):
            if each not in known:
                yield f"pronouns.{word}", f"{each!r} is not a word of the grammar"
    for word in domain.placing:
        if word not in known:
            yield "placing", f"{word!r} is not a word of the grammar"


def _several(domain: Domain) -> Faults:
    """What stands behind the words for several objects are words, and plurals of words."""
    if domain.several is None:
        return
    known = domain.other_words()
    for word in domain.several.between:
        if word not in known:
            yield "several.between", f"{word!r} is not a word of the grammar"
    for word, singular in domain.several.plurals.items():
        if word in domain.group_words():
            yield "several.plurals", f"{word!r} is a word that describes objects"
        if singular not in known:
            yield f"several.plurals.{word}", f"{singular!r} is not a word of the grammar"


def _rephrasing(domain: Domain) -> Faults:
    """Phrases are read as those of the grammar."""
    simpler = domain.simplification
    lists = [("rephrasing", domain.rephrasing)]
    if simpler is not None:
        lists += [("simplification", phrases) for phrases in simpler.texts()]
        if (taking := simpler.taking) is not None:
            lists.append(("simplification.taking", {"put": taking.order, "it": taking.object}))
        if (standing := simpler.standing) is not None:
            lists.append(("simplification.standing", {"block that is": standing.read_as}))
    known = domain.other_words() | domain.group_words()
    for key, phrases in lists:
        if not all(phrases):
            yield key, "expected words: remove the empty string"
        for text in filter(None, phrases.values()):
            for word in text.split(" "):
                if word not in known:
                    yield key, f"{word!r} is not a word of the grammar"


def _exceptions(domain: Domain) -> Faults:
    """Objects are left out in words."""
    said = domain.exceptions
    if said is not None and not all((*said.phrases, *said.negations)):
        yield "exceptions", "expected words: remove the empty string"


def _perspectives(domain: Domain) -> Faults:
    """Whose left is meant is said in words, and opposites are actions, in pairs."""
    said = domain.perspectives
    if said is None:
        return
    if not all((*said.own, *said.other)):
        yield "perspectives", "expected words: remove the empty string"
    names = [action.name for action in domain.actions]
    for name, opposite in said.opposites.items():
        if name not in names:
            yield f"perspectives.opposites.{name}", f"no such action; expected some of {names}"
        if said.opposites.get(opposite) != name:
            yield f"perspectives.opposites.{name}", f"is not the opposite of {opposite}"


def _lists(domain: Domain) -> Faults:
    """Objects are listed in words, and their steps joined by those of the grammar."""
    said = domain.lists
    if said is None:
        return
    if not all((*said.between, *said.them, *said.stacking, *said.aside, said.next)):
        yield "lists", "expected words: remove the empty string"
    for word in said.next.split(" "):
        if word and word not in domain.other_words():
            yield "lists.next", f"{word!r} is not a word of the grammar"


def _repairs(domain: Domain) -> Faults:
    """Words stand before and behind what is taken back."""
    said = domain.repairs
    if said is not None and not all((*said.corrections, *said.exclusions)):
        yield "repairs", "expected words: remove the empty string"


def _sequence(domain: Domain) -> Faults:
    """The order of steps is said in words, and read as those of the grammar."""
    said = domain.sequence
    if said is None:
        return
    if not all(said.said()):
        yield "sequence", "expected words: remove the empty string"
    if both := {*said.earlier} & {*said.afterthoughts}:
        yield "sequence", f"{min(both)!r} is in earlier and in afterthoughts"
    known = domain.other_words()
    for text in (said.next, *filter(None, (*said.later.values(), *said.earlier.values()))):
        for word in text.split(" "):
            if word not in known:
                yield "sequence", f"{word!r} is not a word of the grammar"


def _distances(domain: Domain) -> Faults:
    """Distances are of actions that put something beside another one, said in words, and read as
    those of the grammar."""
    said = domain.distances
    if said is None:
        return
    sides = [action.name for action in domain.actions if action.direction is not None]
    for name in said.sides:
        if name not in sides:
            yield "distances.sides", f"no action {name!r}; expected some of {', '.join(sides)}"
    directions = [text for texts in said.shifts.values() for text in texts]
    around = (*said.before, *said.behind, *said.source, *said.unless, *said.origins)
    if not all((*said.units, *said.numbers, *around, *directions)):
        yield "distances", "expected words: remove the empty string"
    for name in said.shifts:
        if name not in said.sides:
            yield "distances.shifts", f"{name!r} is not in distances.sides"
    if len({*directions}) < len(directions):
        yield "distances.shifts", "expected other words for each direction"
    if directions and not _tells_what_is_on_table(domain):
        yield (
            "distances.shifts",
            "the highest block is at least three times as high as the lowest, so that what stands "
            "on the table cannot be told: leave them out",
        )
    known = domain.other_words()
    for word in said.beside.split(" "):
        if word not in known:
            yield "distances.beside", f"{word!r} is not a word of the grammar"


def _apart(domain: Domain) -> Faults:
    """Words stand between values that are said apart."""
    if domain.apart is not None and not all((*domain.apart.between, *domain.apart.phrases)):
        yield "apart", "expected words between values: remove the empty string"


def _ordinals(domain: Domain) -> Faults:
    """Is counted from extremes of the domain, in words of their own."""
    said = domain.ordinals
    if said is None:
        return
    counts = [word for words in said.counts for word in words]
    if not all(said.counts) or len({*counts}) < len(counts):
        yield "ordinals.counts", "expected one or more words for each number, none of them twice"
    for text, name in (*said.starts.items(), *said.first.items()):
        if name not in domain.extremes:
            yield "ordinals", f"{text!r}: {name!r} has no words in extremes"
    if both := {*said.starts} & {*said.first}:
        yield "ordinals", f"{min(both)!r} is in starts and in first"
    if not all((*counts, *said.starts, *said.first, *said.articles, *said.nouns, *said.unless)):
        yield "ordinals", "expected words: remove the empty string"


def _arrangements(domain: Domain) -> Faults:
    """What is said of towers and rows means steps that are there, in words of the grammar."""
    said = domain.arrangements
    if said is None:
        return
    known = domain.other_words()
    for text in said.read_as():
        for word in text.split(" "):
            if word not in known:
                yield "arrangements", f"{word!r} is not a word of the grammar"
    for name, step in said.steps.items():
        if step.action not in (action.name for action in domain.actions):
            yield f"arrangements.steps.{name}", f"no action {step.action!r}"
    for pattern in said.patterns:
        if not pattern.openings or not all(pattern.openings):
            yield "arrangements.patterns", "expected words before the list"
        for closing, meant in pattern.closings.items():
            if meant not in said.steps:
                yield "arrangements.patterns", f"{closing!r}: no steps {meant!r}"


def _table(domain: Domain) -> Faults:
    """What is said of the table is read as words of the grammar, and as actions that are there."""
    table = domain.table
    if table is None:
        return
    names = [action.name for action in domain.actions]
    for name in (table.action, *table.sides):
        if name not in names:
            yield "table", f"no action {name!r}; expected some of {', '.join(names)}"
    if not 0 < len(table.sides) <= MAX_SIDES:
        yield "table.sides", f"expected 1 to {MAX_SIDES}, got {len(table.sides)}"
    if not _tells_what_is_on_table(domain):
        yield (
            "table",
            "the highest block is at least three times as high as the lowest, so that what stands "
            "on the table cannot be told: leave the table out",
        )
    known = domain.other_words()
    for text in table.read_as():
        for word in text.split(" "):
            if word not in known:
                yield "table", f"{word!r} is not a word of the grammar"
    if not all((*table.off, *table.sources, *table.unless, *table.removing, *table.down)):
        yield "table", "expected words that mean it: remove the empty string"


def _tells_what_is_on_table(domain: Domain) -> bool:
    """Whether the highest block on the table is lower than the lowest one on another."""
    heights_m = [value.edges_m[2] for value in domain.concepts if value.edges_m is not None]
    return 0.5 * max(heights_m) < 1.5 * min(heights_m)


def _compounds(domain: Domain) -> Faults:
    """Compounds are made of actions that are there, and said in texts of their own, which are read
    as words of the grammar."""
    if domain.compounds is None:
        return
    if not all(domain.compounds.sides):
        yield "compounds.sides", "expected words for sides: remove the empty string"
    names = [action.name for action in domain.actions]
    known = domain.other_words()
    seen: dict[str, str] = dict.fromkeys(names, "an action")
    for compound in domain.compounds.made:
        key = f"compounds.made.{compound.name}"
        if compound.name in seen:
            yield key, f"the name is that of {seen[compound.name]}"
        seen[compound.name] = "another compound"
        for name in (*compound.any, *compound.all, *compound.between):
            if name not in names:
                yield key, f"no action {name!r}; expected some of {', '.join(names)}"
        if sum(map(bool, (compound.any, compound.all, compound.between))) != 1:
            yield key, "expected one of any, all and between"
        if len(compound.between) > 1:
            yield f"{key}.between", f"expected 1, got {len(compound.between)}"
        if compound.all and len(compound.all) != COMPOSED:
            yield f"{key}.all", f"expected {COMPOSED}, got {len(compound.all)}"
        if len(compound.any) > MAX_SIDES:
            yield f"{key}.any", f"expected at most {MAX_SIDES}, got {len(compound.any)}"
        if not compound.all and not _tells_what_is_on_table(domain):
            yield (
                key,
                "the highest block is at least three times as high as the lowest, so that what "
                "stands on the table cannot be told: leave out what is any of several actions or "
                "between two objects",
            )
        for word in compound.read.split(" "):
            if word not in known:
                yield key, f"{word!r} is not a word of the grammar"
        for text in compound.said:
            if not text or text in seen:
                yield f"{key}.said", f"{text!r} is empty, or said of {seen.get(text, 'nothing')}"
            seen[text] = compound.name


def _spelling(domain: Domain) -> Faults:
    """Words are heard as known ones, and no known word is taken for an unknown one."""
    if domain.spelling is None:
        return
    known = domain.known_words()
    for word, read_as in domain.spelling.heard.items():
        if word in known:
            yield "spelling.heard", f"{word!r} is a word of the domain"
        if read_as not in known:
            yield f"spelling.heard.{word}", f"{read_as!r} is not a word of the domain"
    for word in domain.spelling.other_words:
        if word in known:
            yield "spelling.other_words", f"{word!r} is a word of the domain"


def _loop(uses: Mapping[str, set[str]]) -> str | None:
    """A rule that contains itself."""
    left = {name: set(used) & uses.keys() for name, used in uses.items()}
    while left:
        done = {name for name, used in left.items() if not used}
        if not done:
            passed, name = set(), min(left)
            while name not in passed:
                passed.add(name)
                name = min(left[name])
            return name
        left = {name: used - done for name, used in left.items() if name not in done}
    return None
