"""The listener of a demonstration, which is notified of its events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import nsrm

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.perception.observer import ObjectNames, Observation
from nsrm_harness.simulation.world import World


class StepResult(Protocol):
    """The result of one sub-goal, as text for people and as JSON for programs."""

    def __str__(self) -> str: ...

    def as_json(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class Stopped:
    """Why the arm did not execute a sub-goal; later ones are not started.

    * `moved`: whether it started
    """

    moved: bool
    message: str

    def __str__(self) -> str:
        return f"{'failed' if self.moved else 'refused'}: {self.message}"

    def as_json(self) -> dict[str, Any]:
        """The same as JSON."""
        return {"failed" if self.moved else "refused": self.message}


class DemoListener:
    """A listener that does nothing; its methods are called in this order."""

    def begin(self, world: World, camera: Camera, known: ObjectNames, sentence: str) -> None:
        """The scene is at rest; nothing has been planned yet."""

    def looked(self, sight: Observation) -> None:
        """The scene was observed: once before the plan, and again after it."""

    def refused(self, refusal: nsrm.Refused) -> None:
        """The sentence was refused; this is the last event."""

    def planned(self, plan: nsrm.Plan) -> None:
        """The plan was made and will be executed."""

    def mark(self, event: str) -> None:
        """The arm has just done `event`."""

    def ended(self, index: int, outcome: StepResult) -> None:
        """A step has ended."""

    def end(self) -> None:
        """The demonstration has ended."""
