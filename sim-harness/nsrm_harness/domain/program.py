"""Programs: the actions, attribute values and relations that a sentence means (Table I)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from nsrm_harness.common.json_text import json_text

#: Relations that compare the objects of a scene, beside those that actions bring about; in the
#: order of a model's relations, behind the actions.
SUPERLATIVES = ("Nearest", "Farthest")


@dataclass(frozen=True)
class Relation:
    """``Relate(name, Unique(Filter(… Scene())))``: what is where an action puts objects, seen
    from another object, or what is nearest to it or farthest from it."""

    #: Name of the action, or one of `SUPERLATIVES`.
    name: str
    #: Names of the concepts that describe the other object.
    to: tuple[str, ...]


@dataclass(frozen=True)
class Step:
    """``Action(action, Unique(Filter(… Scene())), Unique(Filter(… Scene())))``.

    In place of ``Scene()`` there may be a relation to another object, whose description may have
    the next relation.
    """

    #: Name of the action.
    action: str
    #: Names of the concepts that describe the object to be moved.
    object: tuple[str, ...]
    #: Names of the concepts that describe the reference.
    reference: tuple[str, ...]
    object_relations: tuple[Relation, ...] = ()
    reference_relations: tuple[Relation, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The step as in ``{"steps": [...]}`` of the command line."""
        return {
            "action": self.action,
            "object": _as_json(self.object, self.object_relations),
            "reference": _as_json(self.reference, self.reference_relations),
        }

    @staticmethod
    def from_json(content: Mapping[str, Any]) -> Step:
        """The inverse of :meth:`as_json`; other keys are ignored."""
        moved, moved_relations = _from_json(content["object"])
        reference, reference_relations = _from_json(content["reference"])
        return Step(content["action"], moved, reference, moved_relations, reference_relations)


Program = tuple[Step, ...]


def _as_json(concepts: Sequence[str], relations: Sequence[Relation]) -> Any:
    if not relations:
        return list(concepts)
    first, *others = relations
    to = _as_json(first.to, others)
    return {"concepts": list(concepts), "relation": {"name": first.name, "to": to}}


def _from_json(content: Any) -> tuple[tuple[str, ...], tuple[Relation, ...]]:
    if not isinstance(content, Mapping):
        return tuple(content), ()
    relation = content["relation"]
    to, others = _from_json(relation["to"])
    return tuple(content["concepts"]), (Relation(relation["name"], to), *others)


def canonical(steps: Iterable[Step]) -> str:
    """A text that is equal for programs that differ only in the order of filters."""
    return json_text(
        [
            [
                step.action,
                _sorted(step.object, step.object_relations),
                _sorted(step.reference, step.reference_relations),
            ]
            for step in steps
        ],
        ensure_ascii=False,
        separators=(",", ":"),
    )


def _sorted(concepts: Sequence[str], relations: Sequence[Relation]) -> Any:
    return _as_json(
        sorted(concepts),
        [Relation(relation.name, tuple(sorted(relation.to))) for relation in relations],
    )
