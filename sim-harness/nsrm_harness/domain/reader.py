"""Reading a domain file: its tables by their types, then what concerns more than one of them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import DomainError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.toml_file import checked, read_toml, refusal
from nsrm_harness.domain.domain import Attribute, Domain

#: The paper's domain.
DEFAULT = Path(__file__).resolve().parent / "tabletop.toml"
#: Most concepts that may describe one object, a capacity of the core: a domain
#: has no more attribute types than this.
MAX_ATTRIBUTES = 4
#: Indices of concepts and actions are bytes in the core.
MAX_CONCEPTS = 255

Faults = Iterator[tuple[str, str]]
"""Dotted keys, each with what is wrong there."""


def load(path: Path | str = DEFAULT) -> Domain:
    """Read and check a domain file; ``DomainError`` says file, key and what is wrong."""
    path = Path(path)
    return parse(read_toml(path, DomainError, "domain file"), str(path))


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
    read = checked(Domain, document, source, DomainError)
    domain = replace(
        read,
        attributes=tuple(map(_with_its_name, read.attributes)),
        document=json_text(document, ensure_ascii=False),
    )
    for check in (_names, _appearance, _words, _held_out_actions, _held_out):
        if faults := list(check(domain)):
            raise refusal(source, faults, DomainError)
    return domain


def _with_its_name(attribute: Attribute) -> Attribute:
    """Each of its values says of which attribute type it is."""
    values = (replace(value, attribute=attribute.name) for value in attribute.values)
    return replace(attribute, values=tuple(values))


def _names(domain: Domain) -> Faults:
    """None stands twice, and there are no more than the core can hold."""
    for key, named in (
        ("attribute", domain.attributes),
        ("attribute.values", domain.concepts),
        ("action", domain.actions),
    ):
        names = [item.name for item in named]
        for name in dict.fromkeys(names):
            if names.count(name) > 1:
                yield key, f"the name {name!r} is given twice"
    if len(domain.attributes) > MAX_ATTRIBUTES:
        yield "attribute", f"at most {MAX_ATTRIBUTES} types, got {len(domain.attributes)}"
    if len(domain.concepts) > MAX_CONCEPTS:
        yield "attribute.values", f"at most {MAX_CONCEPTS} in all, got {len(domain.concepts)}"


def _appearance(domain: Domain) -> Faults:
    """One attribute type says the colour, one the edges, at most one the studs."""
    for key in ("rgb", "edges_m", "studs"):
        types = {value.attribute for value in domain.concepts if getattr(value, key) is not None}
        if len(types) > 1:
            yield key, f"given by more than one attribute type: {sorted(types)}"
        elif key != "studs" and not types:
            yield key, "no attribute type gives it, but every block needs it"
        elif key != "studs":
            for value in domain.attribute(types.pop()).values:
                if getattr(value, key) is None:
                    yield f"{value.attribute}.{value.name}", f"{key} is missing"


def _words(domain: Domain) -> Faults:
    """Each names one thing."""
    seen: dict[str, str] = {}
    for value in domain.concepts:
        for word in value.words:
            if word in seen:
                yield (
                    f"{value.attribute}.{value.name}.words",
                    f"{word!r} already names {seen[word]!r}",
                )
            seen.setdefault(word, value.name)
    for word in sorted(domain.other_words() & seen.keys()):
        yield "grammar", f"{word!r} names the concept {seen[word]!r} and cannot be another word too"


def _held_out_actions(domain: Domain) -> Faults:
    """It has phrases of every action, and of no other."""
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
    """Nothing of it may stand in the grammar, and no word may be a new one."""
    if domain.held_out is None:
        return
    known = {*domain.vocabulary(), *domain.lexicon()}
    said = {*domain.grammar.commands, *(p for a in domain.actions for p in a.phrases)}
    held_out = domain.held_out
    for text in (*held_out.commands, *(p for each in held_out.phrases.values() for p in each)):
        if text in said:
            yield "held_out", f"{text!r} is no new wording: training has it"
        for word in text.split():
            if not word.startswith("{") and word not in known:
                yield "held_out", f"{word!r} in {text!r} is a word of no other wording"
