"""Says programs in the grammar that a model is first trained on, in which descriptions have
relations, too: "put the block left of the red block on the blue block"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import everyday_of, filled_in
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.domain.program import SUPERLATIVES, Program, Relation


def plain_words(
    domain: Domain, grammar: Grammar, rng: np.random.Generator, program: Program
) -> list[str]:
    """The words of a random wording of `program`."""
    words: list[str] = []
    for step, command in zip(program, grammar.commands(rng, program), strict=True):
        fields = dict(command.fields)
        for argument, concepts, relations in (
            ("moved", step.object, step.object_relations),
            ("reference", step.reference, step.reference_relations),
        ):
            if relations:
                fields[argument] = _plain_description(domain, grammar, rng, concepts, relations)
        words += replace(command, fields=fields).words()
    return words


def _plain_description(
    domain: Domain,
    grammar: Grammar,
    rng: np.random.Generator,
    concepts: Sequence[str],
    relations: Sequence[Relation],
) -> str:
    if not concepts:
        nouns = domain.grammar.nouns
        parts = [f"the {nouns[int(rng.integers(len(nouns)))]}"]
    else:
        parts = [grammar.description(rng, concepts)]
    for relation in relations:
        phrases = _state_phrases(domain, relation.name)
        parts.append(phrases[int(rng.integers(len(phrases)))])
        parts.append(grammar.description(rng, relation.to))
    return " ".join(parts)


def _state_phrases(domain: Domain, name: str) -> list[str]:
    """The phrases of an action that also say what it brings about: "on", but not "onto"; all of a
    superlative."""
    words = everyday_of(domain)
    state = words.states()[name]
    texts = [filled_in(text, state) for text in words.rules[state["state"]]]
    if name in SUPERLATIVES:
        return [text.removesuffix(" {reference}") for text in texts]
    phrases = domain.action(name).phrases
    return [phrase for phrase in phrases if f"{phrase} {{reference}}" in texts]
