"""Actions that are made of others: "next to", "in front and to the left of", "between".

The parser is not taught them: the core reads their words as those of the first action.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from nsrm_harness.common.toml_file import NO_OTHER_KEYS
from nsrm_harness.domain.rewriting import every_text
from nsrm_harness.domain.wording import Identifier, Phrase

#: Number of actions that are done one after the other, a capacity of the core.
COMPOSED = 2


@dataclass(frozen=True)
class Compound:
    """An action that is made of others: of any of some, of all of two, one after the other, or
    halfway between two references."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Its name in programs.
    name: Identifier
    #: How a person says it.
    phrase: Phrase
    #: What means it.
    said: tuple[Phrase, ...]
    #: As what it is read: as what means the first of its actions.
    read: Phrase
    #: The actions of which it is any,
    any: tuple[Identifier, ...] = ()
    #: or those of which it is both,
    all: tuple[Identifier, ...] = ()
    #: or the one that tells how far an object between two others is from them.
    between: tuple[Identifier, ...] = ()

    @property
    def parts(self) -> tuple[str, ...]:
        """The actions that it is made of."""
        return self.between or self.all or self.any


@dataclass(frozen=True)
class Compounds:
    """The actions of a domain that are made of others."""

    __pydantic_config__ = NO_OTHER_KEYS

    made: tuple[Compound, ...] = ()
    #: Words that name a side: near one of them, none of any actions is meant.
    sides: tuple[Phrase, ...] = ()


def compounds_of(
    table: Mapping[str, Any], actions: Collection[str], source: str
) -> dict[str, Any] | None:
    """The compounds of a wording file with all their texts, for a domain with these actions:
    without those that need another one; nothing if none is left."""
    rules = table.get("rules", {})
    made = [
        {
            **compound,
            "said": sorted(
                {
                    said
                    for text in compound.get("said", ())
                    for said in every_text(text, rules, (source, "compounds"))
                }
            ),
            **({"any": there} if "any" in compound else {}),
        }
        for compound in table.get("made", ())
        for there in [[name for name in compound.get("any", ()) if name in actions]]
        if _can_be_made(compound, actions)
    ]
    return {"made": made, "sides": sorted(table.get("sides", ()))} if made else None


def _can_be_made(compound: Mapping[str, Any], actions: Collection[str]) -> bool:
    """Whether the actions are there: all of them, or the one as which any of them is read."""
    needed = {
        *compound.get("all", ()),
        *compound.get("any", ())[:1],
        *compound.get("between", ()),
    }
    return needed <= {*actions}
