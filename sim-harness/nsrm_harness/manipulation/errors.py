"""Why the arm does not begin what it was told."""

from __future__ import annotations

from enum import Enum

from nsrm_harness.common.errors import HarnessError


class RefusalReason(Enum):
    """What stands in the way."""

    UNSEEN = "unseen"
    COVERED = "covered"
    NO_GRASP = "no grasp"
    NO_SUPPORT = "no support"
    UNSTABLE = "unstable"
    NO_ROOM = "no room"
    OUT_OF_REACH = "out of reach"
    NO_WAY = "no way"


class RefusedError(HarnessError):
    """Nothing has moved; the message says what would be touched, or would fall.

    * `in_the_way`: the names of the objects that leave no room or would be touched, without which
      it might be done; the nearest to being far enough away first
    """

    def __init__(self, why: RefusalReason, message: str, in_the_way: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.why = why
        self.in_the_way = in_the_way
