"""Errors for a pick and place that is refused before anything moves."""

from __future__ import annotations

from enum import Enum

from nsrm_harness.common.errors import HarnessError


class RefusalReason(Enum):
    """Why a pick and place is refused."""

    UNSEEN = "unseen"
    COVERED = "covered"
    NO_GRASP = "no grasp"
    NO_SUPPORT = "no support"
    UNSTABLE = "unstable"
    NO_ROOM = "no room"
    OUT_OF_REACH = "out of reach"
    NO_PATH = "no path"


class RefusedError(HarnessError):
    """A pick and place was refused and nothing has moved; the message says what would be touched,
    or would fall.

    * `in_the_way`: the names of the objects that leave no room or would be touched, and without
      which it might be possible; first the one that is closest to being far enough away
    """

    def __init__(self, why: RefusalReason, message: str, in_the_way: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.why = why
        self.in_the_way = in_the_way
