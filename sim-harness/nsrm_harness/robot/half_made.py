"""What a process had half made when it was killed: as `nsrm_ipc::service` does it, for a world
that stands alone."""

from __future__ import annotations

import contextlib
import os
import stat
import time
from pathlib import Path

GIVEN_UP_S = 1.0
"""Making a segment takes a millisecond; one that is half made for so long stays so."""
SEGMENTS = Path("/dev/shm")
"""Where Linux keeps named segments of shared memory."""


def remove_segments(prefix: str) -> bool:
    """Removes segments that were begun and given up; whether some are being made, or may be.

    To be called before iceoryx2 looks at what the dead have left: it waits without end for a
    segment that is still empty.

    * `prefix`: what the names of the robot's segments begin with
    """
    being_made = False
    for entry in os.scandir(SEGMENTS):
        if not entry.name.startswith(prefix):
            continue
        # What has gone meanwhile is not half made.
        with contextlib.suppress(FileNotFoundError):
            found = entry.stat(follow_symlinks=False)
            if found.st_size > 0 and found.st_mode & stat.S_IRUSR:
                continue
            if time.time() - found.st_mtime > GIVEN_UP_S:
                Path(entry.path).unlink()
            else:
                being_made = True
    return being_made
