"""Programs: the actions and attribute values that a sentence means (Table I)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from nsrm_harness.common.json_text import json_text


@dataclass(frozen=True)
class Step:
    """``Action(action, Unique(Filter(… Scene())), Unique(Filter(… Scene())))``."""

    #: Name of the action.
    action: str
    #: Names of the concepts that describe the object to be moved.
    object: tuple[str, ...]
    #: Names of the concepts that describe the reference.
    reference: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The step as in ``{"steps": [...]}`` of the command line."""
        return {
            "action": self.action,
            "object": list(self.object),
            "reference": list(self.reference),
        }

    @staticmethod
    def from_json(content: Mapping[str, Any]) -> Step:
        """The inverse of :meth:`as_json`; other keys are ignored."""
        return Step(content["action"], tuple(content["object"]), tuple(content["reference"]))


Program = tuple[Step, ...]


def canonical(steps: Iterable[Step]) -> str:
    """A text that is equal for programs that differ only in the order of filters."""
    return json_text(
        [[step.action, sorted(step.object), sorted(step.reference)] for step in steps],
        ensure_ascii=False,
        separators=(",", ":"),
    )
