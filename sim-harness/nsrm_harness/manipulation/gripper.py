"""Opens and closes the fingers, and waits until they have arrived or have met something."""

from __future__ import annotations

import math

from nsrm_harness.geometry.panda import GRIP_N
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError, wait

POLL_S = 0.02
"""Interval between two readings of the opening."""
STILL_M = 1e-5
"""The fingers count as at rest if they move by less than this between two readings."""
BEGUN_M = 1e-4
"""The fingers count as moving once they have moved by this."""
BEGIN_S = 0.5
"""Maximum time from a command to the first motion: a gripper that is commanded and read over a
network may need tens of milliseconds."""
MOVE_S = 1.5
"""Maximum time until the fingers are at rest again: from shut to wide open takes 0.8 s."""
THERE_M = 0.001
"""Tolerance of the commanded opening."""


class GripperError(StuckError):
    """The fingers do not move as commanded. The arm stays where it is, and the fingers are told to
    stay as they are: a late motion would surprise people nearby."""


def open_fingers(body: RobotInterface, opening_m: float) -> None:
    """Moves the fingers to this opening, from a wider or a narrower one.

    Bounded by `BEGIN_S` and `MOVE_S`. Raises `GripperError` if they do not reach it.
    """
    _move(body, opening_m)
    if abs(body.opening_m() - opening_m) > THERE_M:
        raise _stuck(body, opening_m, "stopped on the way")


def close_fingers(body: RobotInterface) -> float:
    """Closes the fingers until they meet something, or each other; returns their opening.

    Bounded as `open_fingers`. Raises `GripperError` if they do not move, or do not come to rest.
    """
    _move(body, 0.0)
    return body.opening_m()


def _move(body: RobotInterface, opening_m: float) -> None:
    begin_m = body.opening_m()
    body.grip(opening_m, GRIP_N)
    # Fingers that are already there need not move.
    if abs(begin_m - opening_m) > THERE_M and not _has_begun(body, begin_m):
        raise _stuck(body, opening_m, f"did not move within {BEGIN_S} s")
    if not _stands(body):
        raise _stuck(body, opening_m, f"still moved after {MOVE_S} s")


def _has_begun(body: RobotInterface, begin_m: float) -> bool:
    for _ in range(round(BEGIN_S / POLL_S)):
        wait(body, POLL_S)
        if abs(body.opening_m() - begin_m) > BEGUN_M:
            return True
    return False


def _stands(body: RobotInterface) -> bool:
    before_m = math.inf
    for _ in range(round(MOVE_S / POLL_S)):
        wait(body, POLL_S)
        now_m = body.opening_m()
        if abs(before_m - now_m) < STILL_M:
            return True
        before_m = now_m
    return False


def _stuck(body: RobotInterface, opening_m: float, how: str) -> GripperError:
    now_m = body.opening_m()
    body.grip(now_m, GRIP_N)
    return GripperError(
        f"the fingers were told to go to {1000 * opening_m:.1f} mm, {how} and are "
        f"{1000 * now_m:.1f} mm open; the arm stands still there: look at its hand"
    )
