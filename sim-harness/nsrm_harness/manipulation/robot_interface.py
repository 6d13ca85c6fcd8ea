"""The interface that motions need from an arm and its gripper."""

from __future__ import annotations

from typing import Protocol

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.manipulation.kinematics import Joints


class StuckError(HarnessError):
    """The joints do not follow, or the fingers do not (`GripperError`). The arm is told to stay
    where it is, with its fingers as they are: otherwise, what they hold would fall."""


class RobotInterface(Protocol):
    """The controller of an arm with a gripper, simulated or real."""

    @property
    def tick_s(self) -> float:
        """The time between two ticks."""
        ...

    def drive(self, joints: Joints, speeds: Joints) -> None:
        """Commands the joints, rad and rad/s, from the next tick on."""
        ...

    def grip(self, opening_m: float, force_n: float) -> None:
        """Commands the opening of the fingers, with at most this force, from the next tick on."""
        ...

    def joints(self) -> Joints:
        """The measured angles of the joints."""
        ...

    def opening_m(self) -> float:
        """The measured opening of the fingers: updated within each `gripper.POLL_S`, possibly with
        latency."""
        ...

    def tick(self) -> None:
        """Waits for the next tick."""
        ...


def wait(body: RobotInterface, time_s: float) -> None:
    """Waits for this time, and for at least one tick: with none, whatever is waited for would seem
    to stand still."""
    for _ in range(max(1, round(time_s / body.tick_s))):
        body.tick()
