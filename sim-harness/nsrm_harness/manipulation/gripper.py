"""The fingers on their way: told where to go, waited for until they have been there, or have met
something."""

from __future__ import annotations

import math

from nsrm_harness.geometry.panda import GRIP_N
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError, wait

LOOK_S = 0.02
"""Between two looks at how far they are open."""
STILL_M = 1e-5
"""They stand when they move less than that between two looks."""
BEGUN_M = 1e-4
"""They have begun to move when they have moved by that."""
BEGIN_S = 0.5
"""They begin within that after they were told, or not at all: a gripper that is told by a network,
and reads its width by one, may need tens of milliseconds."""
MOVE_S = 1.5
"""They stand again within that: from shut to wide open takes 0.8 s."""
THERE_M = 0.001
"""They are where they were told to go within that."""


class GripperError(StuckError):
    """The fingers do not move as they are told to. The arm stays where it is, and they are told to
    stay as they are: what they do later would surprise who stands there."""


def open_fingers(body: RobotInterface, opening_m: float) -> None:
    """To that opening, from a wider or a narrower one.

    Bounded by `BEGIN_S` and `MOVE_S`. Raises `GripperError` if they don't get there.
    """
    _move(body, opening_m)
    if abs(body.opening_m() - opening_m) > THERE_M:
        raise _stuck(body, opening_m, "stopped on the way")


def close_fingers(body: RobotInterface) -> float:
    """Until they meet something, or each other; gives how far they are open then.

    Bounded as `open_fingers`. Raises `GripperError` if they don't move, or don't come to a stand.
    """
    _move(body, 0.0)
    return body.opening_m()


def _move(body: RobotInterface, opening_m: float) -> None:
    begin_m = body.opening_m()
    body.grip(opening_m, GRIP_N)
    # Those that are there have nowhere to go.
    if abs(begin_m - opening_m) > THERE_M and not _has_begun(body, begin_m):
        raise _stuck(body, opening_m, f"did not move within {BEGIN_S} s")
    if not _stands(body):
        raise _stuck(body, opening_m, f"still moved after {MOVE_S} s")


def _has_begun(body: RobotInterface, begin_m: float) -> bool:
    for _ in range(round(BEGIN_S / LOOK_S)):
        wait(body, LOOK_S)
        if abs(body.opening_m() - begin_m) > BEGUN_M:
            return True
    return False


def _stands(body: RobotInterface) -> bool:
    before_m = math.inf
    for _ in range(round(MOVE_S / LOOK_S)):
        wait(body, LOOK_S)
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
