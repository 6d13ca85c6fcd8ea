"""A camera that shows nothing for a while is waited for, and not for ever."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import nsrm

from nsrm_harness.manipulation.retries import ManipulationError
from nsrm_harness.manipulation.robot_interface import RobotInterface, wait
from nsrm_harness.perception.relief import PerceptionError

PATIENCE_S, PAUSE_S = nsrm.Limits().scene_wait_ns / 1e9, 0.1
"""So long a camera that shows nothing new is waited for, as by the executive, and so long between
two looks."""

Seen = TypeVar("Seen")


class NoObservationError(ManipulationError):
    """There is no new picture in which anything can be seen."""


def observe_with_timeout(
    body: RobotInterface, look: Callable[[], Seen], now_s: Callable[[], float]
) -> Seen:
    """What is seen on the first picture on which anything is; the arm stands meanwhile.

    * `look`: takes a picture, and raises `PerceptionError` where nothing can be seen on it
    * `now_s`: the time

    Raises `NoObservationError` if there is none for `PATIENCE_S`.
    """
    begun_s = now_s()
    while True:
        try:
            return look()
        except PerceptionError as error:
            if now_s() - begun_s > PATIENCE_S:
                raise NoObservationError(f"{error}; giving up") from None
        wait(body, PAUSE_S)
