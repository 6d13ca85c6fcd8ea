"""How far from the reference an object is put: "two centimetres to the left of the blue block",
which the core reads as "to the left of the blue block" and keeps; and how far it is moved from
where it is, "5 cm to the left".

The parser is not taught it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from nsrm_harness.common.toml_file import NO_OTHER_KEYS
from nsrm_harness.domain.rewriting import every_text_of
from nsrm_harness.domain.wording import Identifier, Phrase

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


@dataclass(frozen=True)
class Distances:
    """Words that say how far from the reference an object is put."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: The actions that put an object beside another one.
    sides: tuple[Identifier, ...]
    #: Units of length, in millimetres.
    units: Mapping[Phrase, Positive]
    #: Numbers in words, beside those in digits.
    numbers: Mapping[Phrase, Positive]
    #: What may stand before a distance and belongs to it, "at a distance of";
    before: tuple[Phrase, ...]
    #: and behind it: "away".
    behind: tuple[Phrase, ...]
    #: What stands between it and the reference where no side is named, "away from",
    #: called `from` in files,
    source: Annotated[tuple[Phrase, ...], Field(alias="from")]
    #: and what is read in its place: "next to".
    beside: Phrase
    #: Words before it with which it is the size of an object: "the" in "the 4 cm block".
    unless: tuple[Phrase, ...]
    #: By action, how a direction is said in which an object is moved from where it is;
    shifts: Mapping[Identifier, tuple[Phrase, ...]]
    #: and what may stand behind it and says nothing more: "from where it is".
    origins: tuple[Phrase, ...]
    #: That of the demonstrations, millimetres.
    usual_mm: Annotated[int, Field(gt=0, lt=1 << 16)]


def distances_of(
    table: Mapping[str, Any], actions: Collection[str], source: str
) -> dict[str, Any] | None:
    """The distances of a wording file with all their texts, and the sides that the domain has;
    nothing without any."""
    sides = [name for name in table.get("sides", ()) if name in actions]
    if not sides:
        return None
    keys = ("before", "behind", "from", "unless", "origins")
    lists = {key: every_text_of(table, key, (source, "distances")) for key in keys}
    said = {name: texts for name, texts in table.get("shifts", {}).items() if name in sides}
    place, rules = (source, "distances.shifts"), {"rules": table.get("rules", {})}
    shifts = {name: every_text_of({**said, **rules}, name, place) for name in said}
    kept = {key: value for key, value in table.items() if key != "rules"}
    return {**kept, "sides": sides, **lists, "shifts": shifts}
