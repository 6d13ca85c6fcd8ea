"""Waits for a usable image of the camera, with a timeout."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import nsrm

from nsrm_harness.manipulation.retries import ManipulationError
from nsrm_harness.manipulation.robot_interface import RobotInterface, wait
from nsrm_harness.perception.relief import PerceptionError

PATIENCE_S, PAUSE_S = nsrm.Limits().scene_wait_ns / 1e9, 0.1
"""Timeout for a camera that shows nothing new, the same as the executive's, and the pause between
two observations."""

Seen = TypeVar("Seen")


class NoObservationError(ManipulationError):
    """No new image in which anything can be seen arrived before the timeout."""


def observe_with_timeout(
    body: RobotInterface, look: Callable[[], Seen], now_s: Callable[[], float]
) -> Seen:
    """The observation from the first image in which anything can be seen; the arm stands still
    meanwhile.

    * `look`: takes an image, and raises `PerceptionError` if nothing can be seen in it
    * `now_s`: the current time

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
