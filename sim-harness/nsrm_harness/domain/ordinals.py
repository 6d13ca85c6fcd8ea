"""What is counted from one side: "the second red block from the left".

The parser is not taught it: the core leaves these words out, and what they mean becomes a part of
the description.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from nsrm_harness.common.toml_file import NO_OTHER_KEYS
from nsrm_harness.domain.rewriting import every_text
from nsrm_harness.domain.wording import Identifier, Phrase


@dataclass(frozen=True)
class Ordinals:
    """How is counted from one side."""

    __pydantic_config__ = NO_OTHER_KEYS

    #: Words that count 1, 2 and so on; the first of each names what is counted, "second leftmost".
    counts: tuple[tuple[Phrase, ...], ...]
    #: From where is counted, "from the left", each with the name of the extreme;
    starts: Mapping[Phrase, Identifier]
    #: and what also means this itself where nothing is counted, "on the far left".
    first: Mapping[Phrase, Identifier]
    #: Words that stand before a count without a noun.
    articles: tuple[Phrase, ...]
    #: Words that may stand between a description and from where is counted.
    nouns: tuple[Phrase, ...]
    #: Words behind "from the left" with which it means something else.
    unless: tuple[Phrase, ...]

    def texts_of(self, extreme: str) -> list[str]:
        """What says that is counted from an extreme."""
        every = (*self.starts.items(), *self.first.items())
        return [text for text, name in every if name == extreme]


def ordinals_of(
    table: Mapping[str, Any], extremes: Collection[str], nouns: Iterable[str], source: str
) -> dict[str, Any] | None:
    """The ordinals of a wording file with all their texts, for a domain with these extremes;
    nothing if nothing can be counted.

    `nouns`: the alternatives of the rule for them
    """
    rules = table.get("rules", {})

    def named(key: str) -> dict[str, str]:
        return {
            text: name
            for name, texts in table.get(key, {}).items()
            if name in extremes
            for each in texts
            for text in every_text(each, rules, (source, "ordinals"))
        }

    if not (starts := named("starts")):
        return None
    return {
        "counts": table.get("counts", []),
        "starts": starts,
        "first": named("first"),
        "articles": sorted(table.get("articles", ())),
        "nouns": sorted({word for noun in nouns for word in noun.split(" ") if word[0] != "{"}),
        "unless": sorted(table.get("unless", ())),
    }
