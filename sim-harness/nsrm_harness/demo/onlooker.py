"""Who is told what happens in a demonstration."""

from __future__ import annotations

import nsrm

from nsrm_harness.demo.outcome import Outcome
from nsrm_harness.sight import Names, Sight
from nsrm_harness.world.camera import Camera
from nsrm_harness.world.world import World


class Onlooker:
    """Is told all of it, in this order, and does nothing."""

    def begin(self, world: World, camera: Camera, known: Names, sentence: str) -> None:
        """All stands at rest; nothing has been planned."""

    def looked(self, sight: Sight) -> None:
        """A picture was taken: one before the plan, others after it."""

    def refused(self, refusal: nsrm.Refused) -> None:
        """There is no plan; this is the end."""

    def planned(self, plan: nsrm.Plan) -> None:
        """What is going to be carried out."""

    def mark(self, event: str) -> None:
        """The arm has just done this."""

    def ended(self, index: int, outcome: Outcome) -> None:
        """How a step went, by its index."""

    def end(self) -> None:
        """Nothing more is done."""
