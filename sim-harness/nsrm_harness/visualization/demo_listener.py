"""Who is told what happens in a demonstration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import nsrm

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.perception.observer import ObjectNames, Observation
from nsrm_harness.simulation.world import World


class StepResult(Protocol):
    """How one sub-goal went: a text for people, and the same for programs."""

    def __str__(self) -> str: ...

    def as_json(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class Stopped:
    """Why the arm did not carry a sub-goal out; those after it are not begun.

    * `moved`: whether it began
    """

    moved: bool
    message: str

    def __str__(self) -> str:
        return f"{'failed' if self.moved else 'refused'}: {self.message}"

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {"failed" if self.moved else "refused": self.message}


class DemoListener:
    """Is told all of it, in this order, and does nothing."""

    def begin(self, world: World, camera: Camera, known: ObjectNames, sentence: str) -> None:
        """All stands at rest; nothing has been planned."""

    def looked(self, sight: Observation) -> None:
        """A picture was taken: one before the plan, others after it."""

    def refused(self, refusal: nsrm.Refused) -> None:
        """There is no plan; this is the end."""

    def planned(self, plan: nsrm.Plan) -> None:
        """What is going to be carried out."""

    def mark(self, event: str) -> None:
        """The arm has just done this."""

    def ended(self, index: int, outcome: StepResult) -> None:
        """How a step went, by its index."""

    def end(self) -> None:
        """Nothing more is done."""
