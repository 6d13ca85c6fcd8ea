"""What the motions ask of an arm and its hand."""

from __future__ import annotations

from typing import Protocol

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.manipulation.kinematics import Joints


class StuckError(HarnessError):
    """The joints do not follow, or the fingers (`GripperError`). The arm is told to stay where it
    is, with its fingers as they are: what they hold would fall."""


class RobotInterface(Protocol):
    """An arm with a hand, as its controller has it: a simulated or a real one."""

    @property
    def tick_s(self) -> float:
        """Between two ticks."""
        ...

    def drive(self, joints: Joints, speeds: Joints) -> None:
        """What the joints follow, rad and rad/s, from the next tick on."""
        ...

    def grip(self, opening_m: float, force_n: float) -> None:
        """Where the fingers go with at most this force, from the next tick on."""
        ...

    def joints(self) -> Joints:
        """Where the joints are."""
        ...

    def opening_m(self) -> float:
        """Between the fingers: measured anew in each `fingers.LOOK_S`, if late."""
        ...

    def tick(self) -> None:
        """Waits for the next tick."""
        ...


def wait(body: RobotInterface, time_s: float) -> None:
    """Lets so much time go by, and a tick at least: else what is waited for would seem to stand."""
    for _ in range(max(1, round(time_s / body.tick_s))):
        body.tick()
