"""Finds commands whose relations may belong to either of two descriptions: "the red block on the
blue block left of the green one" may be put on a block or left of one.

Nothing in such a sentence tells which is meant.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from nsrm_harness.domain.domain import GROUP_TOKEN, Domain
from nsrm_harness.domain.everyday import everyday_of, own_texts, state_texts
from nsrm_harness.domain.recogniser import Recogniser, recognised_rules

#: Names of the rules for chains of one and of two relations.
LEVELS = ("one", "two")


class Attachments:
    """Counts the readings of a domain's steps, which differ in what each relation belongs to."""

    def __init__(self, domain: Domain) -> None:
        words = everyday_of(domain)
        rules: dict[str, Sequence[str]] = {"#anchor_plain": ("{description}",)}
        kinds: dict[str, int] = {"#anchor_plain": 1}
        anchors = ("#anchor_plain", "#anchor_one")
        for links, (level, anchor) in enumerate(zip(LEVELS, anchors, strict=True), start=1):
            texts = state_texts(words) if links == 1 else _without_owners(state_texts(words))
            rules[f"#relating_{level}"] = _with(texts, "reference", anchor)
            for rule, name, values in (("related", "anchor", 1), ("undescribed", "bare", 0)):
                texts = _with(words.rules[rule], "relating", f"#relating_{level}")
                own = _with(own_texts(words, rule), "reference", anchor)
                rules[f"#{name}_{level}"] = [*texts, *own]
                kinds[f"#{name}_{level}"] = values + links
        relations = recognised_rules(domain)["relation"]
        #: For each pair of kinds of descriptions: the number of descriptions, and its recogniser.
        self._readings = [
            (
                kinds[moved] + kinds[reference],
                Recogniser.of(
                    domain,
                    {
                        **rules,
                        "moved": (f"{{{moved}}}",),
                        "reference": (f"{{{reference}}}",),
                        "relation": relations
                        if reference == "#anchor_plain"
                        else _without_owners(relations),
                    },
                ),
            )
            for moved, reference in itertools.product(kinds, repeat=2)
        ]

    def is_ambiguous(self, words: Sequence[str]) -> bool:
        """Whether the words of a step, with group tokens, have several readings."""
        return len(list(itertools.islice(self._of(words), 2))) > 1

    def _of(self, words: Sequence[str]) -> Iterator[Recogniser]:
        count = sum(word == GROUP_TOKEN for word in words)
        for groups, recogniser in self._readings:
            if groups == count and recogniser.step(words):
                yield recogniser


def _without_owners(texts: Sequence[str]) -> list[str]:
    """The alternatives without an owner, who has no relations."""
    return [text for text in texts if "{possessor}" not in text]


def _with(texts: Sequence[str], rule: str, other: str) -> list[str]:
    """The alternatives with another rule in place of one."""
    return [text.replace(f"{{{rule}}}", f"{{{other}}}") for text in texts]
