"""Programs: the actions, attribute values and relations that a sentence means (Table I)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from nsrm_harness.common.json_text import json_text

#: Relations that compare the objects of a scene, beside those that actions bring about; in the
#: order of a model's relations, behind the actions.
SUPERLATIVES = ("Nearest", "Farthest")
#: What is no relation, but names a further reference of what is put or lies between two.
AND = "And"


#: What chooses among objects by their size, beside the extremes in the directions of actions.
SIZE_EXTREMES = ("Largest", "Smallest")
#: What says that several objects are moved, in place of an extreme: all that fit, and both of two.
#: Once it is grounded, such a step is one for each of them.
ALL, BOTH, EACH = "all", "both", "each"
#: What says that the table is meant, and no object: as the reference of a step, and of a relation.
TABLE = "table"
#: What says that an object is moved from where it is, or that several are moved in relation to each
#: other: as the reference of a step.
ITSELF = "itself"


@dataclass(frozen=True)
class Relation:
    """``Relate(name, Unique(Filter(… Scene())))``: what is where an action puts objects, seen
    from another object, or what is nearest to it or farthest from it."""

    #: Name of the action, one of `SUPERLATIVES`, or `AND`.
    name: str
    #: Names of the concepts that describe the other object.
    to: tuple[str, ...]
    #: Which of several such objects: the name of an extreme, "leftmost" or "largest"; or `TABLE`.
    which: str | None = None


@dataclass(frozen=True)
class Excepted:
    """``Except(Unique(Filter(… Scene())), …)``: objects that are not meant though all else fits."""

    #: Names of the concepts that describe them.
    values: tuple[str, ...]
    #: `ALL` for any number of them, None for a single one.
    which: str | None = None


@dataclass(frozen=True)
class Step:
    """``Action(action, Unique(Filter(… Scene())), Unique(Filter(… Scene())))``.

    In place of ``Scene()`` there may be a relation to another object, whose description may have
    the next relation; and between ``Unique`` and ``Filter`` may stand ``Extreme``, which chooses
    among the objects that fit.
    """

    #: Name of the action.
    action: str
    #: Names of the concepts that describe the object to be moved.
    object: tuple[str, ...]
    #: Names of the concepts that describe the reference.
    reference: tuple[str, ...]
    object_relations: tuple[Relation, ...] = ()
    reference_relations: tuple[Relation, ...] = ()
    #: Which of several objects that fit is to be moved: the name of an extreme, "leftmost", or
    #: `ALL`, `BOTH` or `EACH` of them.
    object_which: str | None = None
    #: Which of several is the reference, `TABLE`, or `ITSELF`.
    reference_which: str | None = None
    #: The distance between the faces of the two, if the sentence names one; from `ITSELF`, that by
    #: which the object is moved.
    distance_mm: int | None = None
    #: What is left out of the objects to be moved, and of the reference.
    object_except: Excepted | None = None
    reference_except: Excepted | None = None

    def as_json(self) -> dict[str, Any]:
        """The step as in ``{"steps": [...]}`` of the command line."""
        content = {
            "action": self.action,
            "object": _as_json(
                self.object, self.object_which, self.object_relations, self.object_except
            ),
            "reference": _as_json(
                self.reference,
                self.reference_which,
                self.reference_relations,
                self.reference_except,
            ),
        }
        if self.distance_mm is not None:
            content["distance_mm"] = self.distance_mm
        return content

    @staticmethod
    def from_json(content: Mapping[str, Any]) -> Step:
        """The inverse of :meth:`as_json`; other keys are ignored."""
        moved, moved_which, moved_relations = _from_json(content["object"])
        reference, reference_which, reference_relations = _from_json(content["reference"])
        left_out = (_excepted(content[key]) for key in ("object", "reference"))
        return Step(
            content["action"],
            moved,
            reference,
            moved_relations,
            reference_relations,
            moved_which,
            reference_which,
            content.get("distance_mm"),
            *left_out,
        )


Program = tuple[Step, ...]


def _as_json(
    concepts: Sequence[str],
    which: str | None,
    relations: Sequence[Relation],
    left_out: Excepted | None = None,
) -> Any:
    if which is None and left_out is None and not relations:
        return list(concepts)
    content: dict[str, Any] = {"concepts": list(concepts)}
    if which is not None:
        content["which"] = which
    if left_out is not None:
        content["except"] = _as_json(left_out.values, left_out.which, ())
    if relations:
        first, *others = relations
        to = _as_json(first.to, first.which, others)
        content["relation"] = {"name": first.name, "to": to}
    return content


def _from_json(content: Any) -> tuple[tuple[str, ...], str | None, tuple[Relation, ...]]:
    if not isinstance(content, Mapping):
        return tuple(content), None, ()
    concepts, which = tuple(content["concepts"]), content.get("which")
    if (relation := content.get("relation")) is None:
        return concepts, which, ()
    to, to_which, others = _from_json(relation["to"])
    return concepts, which, (Relation(relation["name"], to, to_which), *others)


def _excepted(content: Any) -> Excepted | None:
    left_out = content.get("except") if isinstance(content, Mapping) else None
    if left_out is None:
        return None
    values, which, _ = _from_json(left_out)
    return Excepted(values, which)


def canonical(steps: Iterable[Step]) -> str:
    """A text that is equal for programs that differ only in the order of filters."""
    return json_text(
        [
            [
                step.action,
                _sorted(step.object, step.object_which, step.object_relations, step.object_except),
                _sorted(
                    step.reference,
                    step.reference_which,
                    step.reference_relations,
                    step.reference_except,
                ),
                *([] if step.distance_mm is None else [step.distance_mm]),
            ]
            for step in steps
        ],
        ensure_ascii=False,
        separators=(",", ":"),
    )


def _sorted(
    concepts: Sequence[str],
    which: str | None,
    relations: Sequence[Relation],
    left_out: Excepted | None,
) -> Any:
    return _as_json(
        sorted(concepts),
        which,
        [replace(relation, to=tuple(sorted(relation.to))) for relation in relations],
        left_out and replace(left_out, values=tuple(sorted(left_out.values))),
    )
