"""The only timeline of a recording."""

from __future__ import annotations

import numpy as np
import rerun as rr

from nsrm_harness.simulation.world import World

TIMELINE = "sim_time"
"""Simulated seconds since the world was created."""


def duration(time_s: float) -> np.timedelta64:
    """Rounds to whole nanoseconds; Rerun would truncate."""
    return np.timedelta64(round(time_s * 1e9), "ns")


class Log:
    """Logs the events of a world to a recording."""

    def __init__(self, stream: rr.RecordingStream, world: World) -> None:
        self.stream, self.world = stream, world

    def always(self, entity: str, *what: rr.AsComponents) -> None:
        """Logs static data."""
        self.stream.log(entity, *what, static=True)

    def now(self, entity: str, *what: rr.AsComponents) -> None:
        """Logs data from now on."""
        self.stream.set_time(TIMELINE, duration=duration(self.world.time_s))
        self.stream.log(entity, *what)
