"""The programs that explain demonstrations, as steps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from nsrm_harness.data.relations import Described
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import SUPERLATIVES, Relation, Step
from nsrm_harness.learning.dataset import GROUPS_PER_STEP, Sentences
from nsrm_harness.learning.explain import Explained
from nsrm_harness.learning.structures import Structures, structures

SMALL_BATCHES = ("nsrm_harness.learning.explain.CHUNK", 16)
"""For `monkeypatch.setattr`. Batches are filled up: with a few dozen sentences, the trainer's are
mostly filling."""


def programs_of(
    found: Explained, sentences: Sentences, domain: Domain
) -> Iterator[tuple[int, list[Step]]]:
    """The index of the sentence of each explained step, and the steps that explain it."""
    names = [action.name for action in domain.actions]
    relations = [*names, *SUPERLATIVES]
    table = structures(len(relations))
    for index, number, programs in zip(*found, strict=True):
        groups = [
            tuple(domain.concepts[concept].name for concept in group if concept >= 0)
            for group in sentences.groups[index][: sentences.group_count[index]]
        ]
        yield (
            int(index),
            [
                _step(
                    table, structure, relations, names[action], groups[GROUPS_PER_STEP * number :]
                )
                for structure, action in (divmod(int(p), len(names)) for p in programs if p >= 0)
            ],
        )


def _step(
    table: Structures, number: int, names: list[str], action: str, groups: list[tuple[str, ...]]
) -> Step:
    said: dict[int, Described] = {}
    head = 0
    for at, group in enumerate(groups[: table.count[number]]):
        role = int(table.roles[number][at])
        relation = Relation(names[(role - 1) % len(names)], group)
        if role == 0:
            head, said[at] = at, Described(group, ())
        elif role > len(names):
            head, said[at] = at, Described((), (relation,))
        else:
            said[head] = replace(said[head], relations=(*said[head].relations, relation))
    moved, reference = said[int(table.moved[number])], said[int(table.reference[number])]
    return Step(action, moved.concepts, reference.concepts, moved.relations, reference.relations)
