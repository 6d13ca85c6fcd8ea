"""Why the arm does not begin what it was told."""

from __future__ import annotations

from enum import Enum

from nsrm_harness.errors import HarnessError


class Why(Enum):
    """What stands in the way."""

    UNSEEN = "unseen"
    COVERED = "covered"
    NO_SUPPORT = "no support"
    UNSTABLE = "unstable"
    NO_ROOM = "no room"
    OUT_OF_REACH = "out of reach"
    NO_WAY = "no way"


class RefusedError(HarnessError):
    """Nothing has moved; the message says what would be touched, or would fall."""

    def __init__(self, why: Why, message: str) -> None:
        super().__init__(message)
        self.why = why
