"""What the core rewrites before it reads a sentence: phrases that it reads as others, what is left
out of a description, which it keeps apart, what is taken back, which it leaves out, steps in
another order than that in which they are carried out, values that stand apart, which it joins, the
table where it is meant and not named, and towers and rows, which it reads as their steps.

The parser is not taught them.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from nsrm_harness.common.errors import DomainError
from nsrm_harness.common.toml_file import NO_OTHER_KEYS
from nsrm_harness.domain.wording import ConceptWords, Identifier, Phrase

#: Marks that may be left over where the words between two of them are left out.
MARKS = (",", ".", ":", "!", "?")
#: What has phrases of what a refused sentence is read again without.
PHRASES = ("opening", "anywhere", "closing", "connecting")
_RULE = re.compile(r"\{([a-z_]+)\}")


@dataclass(frozen=True)
class Taking:
    """How something is said to be taken and put somewhere in fewer words than a command has."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words that only take an object, "take";
    words: tuple[Phrase, ...]
    #: words that say where it is put, and never where it is, "onto";
    towards: tuple[Phrase, ...]
    #: what is read in place of the former before the latter, "put";
    order: Phrase
    #: and where the object is not named again, "it".
    object: Phrase


@dataclass(frozen=True)
class Standing:
    """How an object without attributes is said to stand somewhere, "the block left of the red one",
    and in which words this is read: "the thing standing left of the red one"."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: What may stand between the noun and the relation, "that is";
    clauses: tuple[Phrase, ...]
    #: words with which relations begin, "left";
    relations: tuple[Phrase, ...]
    #: what is read in place of noun and clause, "thing standing".
    read_as: Phrase


@dataclass(frozen=True)
class Simplification:
    """What a refused sentence is read again without, and phrases that are then read as simpler
    ones; an empty text for what is left out."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: At its beginning,
    opening: Mapping[Phrase, Phrase]
    #: at any place,
    anywhere: Mapping[Phrase, Phrase]
    #: at its end,
    closing: Mapping[Phrase, Phrase]
    #: and at the beginning of each further step, where they only connect it to the one before.
    connecting: Mapping[Phrase, Literal[""]] = field(default_factory=dict)
    #: Words by which a step is said to be the first, before which nothing is left out.
    starting: tuple[Phrase, ...] = ()
    #: How an object is taken that is put somewhere.
    taking: Taking | None = None
    #: How an object is described by where it stands alone.
    standing: Standing | None = None

    def texts(self) -> tuple[Mapping[Phrase, Phrase], ...]:
        """All lists."""
        return tuple(getattr(self, key) for key in PHRASES)

    def simplified(self, words: Sequence[str], articles: Collection[str]) -> list[str]:
        """What is left of a sentence: see ``nsrm_core::model::Simplification``.

        What is taken or stands somewhere is not read in other words here, nor are values put before
        their nouns.
        """
        words, at = [*words], 0
        while at < len(words):
            found = self._longest(words, at)
            if found is None:
                at += 1
                continue
            length, read_as = found
            words[at : at + length] = read_as.split()
            if read_as:
                at += len(read_as.split())
                continue
            before, behind = (words[each : each + 1] for each in (max(at - 1, 0), at))
            if at == 0:
                del words[: int(bool(behind) and behind[0] in MARKS)]
            elif before[0] not in MARKS:
                if behind == [","] and before[0] in articles:
                    del words[at]
            elif not behind or (before == [","] and behind[0] in MARKS and behind != [","]):
                at -= 1
                del words[at]
            elif behind[0] in MARKS:
                is_inside = before == behind == [","] and at > 1 and words[at - 2] in articles
                at -= is_inside
                del words[at : at + 1 + is_inside]
            # A phrase may begin with the mark before.
            at -= at > 0 and words[at - 1] in MARKS
        return words

    def _longest(self, words: Sequence[str], at: int) -> tuple[int, str] | None:
        found: tuple[int, str] | None = None
        for length in range(1, len(words) - at + 1):
            text = " ".join(words[at : at + length])
            if at == 0 and text in self.opening:
                found = length, self.opening[text]
            elif text in self.anywhere:
                found = length, self.anywhere[text]
            elif at + length == len(words) and text in self.closing:
                found = length, self.closing[text]
        return found


@dataclass(frozen=True)
class Exceptions:
    """Words by which objects are left out of a description."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Before a description of objects that are left out: "except".
    phrases: tuple[Phrase, ...]
    #: Before values that an object does not have: "that is not".
    negations: tuple[Phrase, ...]


@dataclass(frozen=True)
class Lists:
    """How several objects are listed that are moved."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words between two of them, with or without a comma before: "and";
    between: tuple[Phrase, ...]
    #: what they are called where they were taken before: "them";
    them: tuple[Phrase, ...]
    #: and what is read between two steps: ", then".
    next: Phrase
    #: Words that put several on each other, "stack": with a word of `aside`, they mean a tower
    #: there.
    stacking: tuple[Phrase, ...] = ()
    #: Words for a place beside another object: "left".
    aside: tuple[Phrase, ...] = ()

    def is_tower_aside(self, words: Iterable[str]) -> bool:
        """Whether the words of a step about several objects, "stack all blocks left of it", mean a
        tower beside another object."""
        said = {*words}
        return bool(said & {*self.stacking}) and bool(said & {*self.aside})


@dataclass(frozen=True)
class Perspectives:
    """How a person says whose left is meant."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: What means the person's own: "as i see it";
    own: tuple[Phrase, ...]
    #: what means that of someone who looks the other way, "as you see it";
    other: tuple[Phrase, ...]
    #: and the actions that have another one in the opposite direction, each with that.
    opposites: Mapping[Identifier, Identifier]


@dataclass(frozen=True)
class Repairs:
    """Words by which a speaker takes a description back, or rules one out."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Between a description and the one that is meant: "no".
    corrections: tuple[Phrase, ...]
    #: Between the description that is meant and another one: "instead of".
    exclusions: tuple[Phrase, ...]


@dataclass(frozen=True)
class SequenceWords:
    """Words that say in which order two steps are carried out."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Before the step that is carried out second, "before you", each with what is read in their
    #: place, or an empty text;
    later: Mapping[Phrase, Phrase]
    #: and before the one that is carried out first, "after you".
    earlier: Mapping[Phrase, Phrase]
    #: Before that one if it is said behind the other one only: "but first".
    afterthoughts: tuple[Phrase, ...]
    #: What is read between the two: ", then".
    next: Phrase

    def said(self) -> tuple[str, ...]:
        """All words that say the order."""
        return (*self.later, *self.earlier, *self.afterthoughts)


@dataclass(frozen=True)
class Apart:
    """What may stand between values of one object that are said apart: they are read as if they
    stood together."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Directly between values: "small and red block".
    between: tuple[Phrase, ...]
    #: Between an object and another of its values, "that is" in "the small block that is red".
    phrases: tuple[Phrase, ...]


@dataclass(frozen=True)
class ArrangedStep:
    """As what the steps of an arrangement are read: "put", the object, "on", the one before it."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: What is done with each object, in relation to the one before it.
    action: Identifier
    #: What is read before the object that is moved,
    order: Phrase
    #: and between it and the one before it.
    relation: Phrase
    #: Whether the list begins with the last object: "from top to bottom".
    reversed: bool = False


@dataclass(frozen=True)
class Pattern:
    """What may stand before and behind the objects of a list."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Before it: "build a tower of".
    openings: tuple[Phrase, ...]
    #: Behind it, or an empty text for nothing, each with the name of what is then meant.
    closings: Mapping[Phrase, Identifier]


@dataclass(frozen=True)
class Arrangements:
    """How towers and rows are said."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words between the objects of a list: "," and "and".
    between: tuple[Phrase, ...]
    #: Words before which a list ends: "then".
    ends: tuple[Phrase, ...]
    #: What is read between two steps: ", then".
    next: Phrase
    #: What is meant, by name.
    steps: Mapping[Identifier, ArrangedStep]
    #: What is said.
    patterns: tuple[Pattern, ...]

    def read_as(self) -> Iterable[str]:
        """The texts that are read in place of what is said."""
        steps = self.steps.values()
        return (self.next, *(text for step in steps for text in (step.order, step.relation)))


@dataclass(frozen=True)
class Table:
    """The table as a place."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words for it.
    words: ConceptWords
    #: The action that is said of it: "put the red block on the table".
    action: Identifier
    #: Those by which a free place is found, beside an object on the table.
    sides: tuple[Identifier, ...]
    #: What stands between an object and the one that it is taken off,
    off: tuple[Phrase, ...]
    #: what is read instead,
    standing: Phrase
    #: and what before the table behind it, if nothing else says where to.
    order: Phrase
    #: What means the table if nothing else says where to,
    down: tuple[Phrase, ...]
    #: and what is read before the table behind it.
    relation: Phrase
    #: What may stand in the place of `off`, too, and also says other things: it is read so where
    #: something is removed, or where another place follows.
    sources: tuple[Phrase, ...] = ()
    #: Words before these in a clause with which they say other things: "farthest".
    unless: tuple[Phrase, ...] = ()
    #: Words for taking an object off another one that say that it is put on the table,
    removing: tuple[Phrase, ...] = ()
    #: and what is read in their place.
    taking: Phrase = ""

    def read_as(self) -> tuple[str, ...]:
        """The texts that are read in place of what is said."""
        taking = [self.taking] if self.removing else []
        return self.standing, self.order, self.relation, *taking


def with_sides(table: Mapping[str, Any], actions: Collection[str]) -> dict[str, Any] | None:
    """The table of a wording file with the sides that the domain has; nothing without any, or
    without the action."""
    sides = [name for name in table.get("sides", ()) if name in actions]
    is_place = sides and table.get("action") in actions
    return {**table, "sides": sides} if is_place else None


def exceptions_of(table: Mapping[str, Any], source: str) -> dict[str, Any] | None:
    """The exceptions of a wording file with all their texts; nothing if there are none."""
    return _texts_of(table, ("phrases", "negations"), (source, "exceptions"))


def perspectives_of(
    table: Mapping[str, Any], actions: Collection[str], source: str
) -> dict[str, Any] | None:
    """The points of view of a wording file with all their texts, for a domain with these actions;
    nothing if one of them has an opposite that the domain does not have."""
    texts = _texts_of(table, ("own", "other"), (source, "perspectives"))
    if texts is None:
        return None
    opposites = {
        name: other for name, other in table.get("opposites", {}).items() if name in actions
    }
    if not {*opposites.values()} <= {*actions}:
        return None
    return {**texts, "opposites": opposites}


def repairs_of(table: Mapping[str, Any], source: str) -> dict[str, Any] | None:
    """The repairs of a wording file with all their texts; nothing if there are none."""
    return _texts_of(table, ("corrections", "exclusions"), (source, "repairs"))


def _texts_of(
    table: Mapping[str, Any], keys: Iterable[str], place: tuple[str, str]
) -> dict[str, Any] | None:
    texts = {key: every_text_of(table, key, place) for key in keys}
    return texts if any(texts.values()) else None


def rephrasing_of(table: Mapping[str, Any], source: str) -> dict[str, str] | None:
    """Each phrase of a wording file that is read as another one, and that one; nothing if there is
    none."""
    rules = table.get("rules", {})
    phrases = {read_as: texts for read_as, texts in table.items() if read_as != "rules"}
    return _phrases_of(phrases, rules, (source, "rephrasing")) or None


def simplification_of(table: Mapping[str, Any], source: str) -> dict[str, Any] | None:
    """What a wording file leaves out or reads in simpler words; nothing if that is nothing."""
    rules, place = table.get("rules", {}), (source, "simplification")
    lists: dict[str, Any] = {key: _phrases_of(table.get(key, {}), rules, place) for key in PHRASES}
    lists |= {key: table[key] for key in ("starting", "taking", "standing") if key in table}
    return lists if any(lists.values()) else None


def _phrases_of(
    phrases: Mapping[str, Iterable[str]],
    rules: Mapping[str, list[str]],
    place: tuple[str, str],
) -> dict[str, str]:
    """What is read as each of these phrases, with what it is read as."""
    read = {
        each: read_as
        for read_as, texts in phrases.items()
        for text in texts
        for each in every_text(text, rules, place)
    }
    return dict(sorted(read.items()))


def sequence_of(table: Mapping[str, Any], source: str) -> dict[str, Any] | None:
    """The order of steps of a wording file with all its texts; nothing if none can be said."""
    if not table:
        return None
    rules = table.get("rules", {})

    def every(text: str) -> list[str]:
        return every_text(text, rules, (source, "sequence"))

    read = {
        key: {each: read_as for text, read_as in table.get(key, {}).items() for each in every(text)}
        for key in ("later", "earlier")
    }
    afterthoughts = every_text_of(table, "afterthoughts", (source, "sequence"))
    return {**read, "afterthoughts": afterthoughts, "next": table.get("next", "")}


def expanded(
    table: Mapping[str, Any], actions: Iterable[str], rules: Mapping[str, list[str]], source: str
) -> dict[str, Any] | None:
    """The table of a wording file with what its rules stand for, without what the domain has no
    actions for; nothing if nothing is left.

    `rules`: those of the wording file, beside the table's own
    """
    table = dict(table)
    rules = {**rules, **table.pop("rules", {})}
    ends = {
        end.split(" ")[0]
        for text in table.get("ends", ())
        for end in every_text(text, rules, (source, "arrangements"))
    }
    steps = {
        name: step for name, step in table.get("steps", {}).items() if step.get("action") in actions
    }
    patterns = []
    for pattern in table.get("patterns", ()):
        closings = {
            closing: meant
            for text, meant in pattern.get("closings", {}).items()
            for closing in every_text(text, rules, (source, "arrangements"))
            if meant in steps or meant not in table.get("steps", {})
        }
        openings = [
            opening
            for text in pattern.get("openings", ())
            for opening in every_text(text, rules, (source, "arrangements"))
        ]
        if closings:
            patterns.append({"openings": sorted({*openings}), "closings": closings})
    return (
        {**table, "ends": sorted(ends), "steps": steps, "patterns": patterns} if patterns else None
    )


def every_text_of(table: Mapping[str, Any], key: str, where: tuple[str, str]) -> list[str]:
    """All texts that those of a list stand for, sorted, with the table's own rules.

    `where`: file and name of the table, for errors
    """
    rules = table.get("rules", {})
    texts = table.get(key, ())
    return sorted({each for text in texts for each in every_text(text, rules, where)})


def every_text(text: str, rules: Mapping[str, list[str]], table: tuple[str, str]) -> list[str]:
    """All texts that one with names of rules stands for.

    `table`: file and name of the table that it is in, for errors
    """
    found = _RULE.search(text)
    if found is None:
        return [text]
    name = found.group(1)
    if name not in rules:
        file, of = table
        raise DomainError(f"{file}: {of}: no rule {name!r}; add it to {of}.rules")
    # Without the rule, so that none contains itself.
    others = {other: texts for other, texts in rules.items() if other != name}
    chosen = [
        each for alternative in rules[name] for each in every_text(alternative, others, table)
    ]
    before, behind = text[: found.start()], text[found.end() :]
    return [
        f"{before}{alternative}{rest}"
        for alternative in chosen
        for rest in every_text(behind, rules, table)
    ]
