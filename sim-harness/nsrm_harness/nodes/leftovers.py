"""Cleans up what a killed process left half created, like `nsrm_ipc::service`, for a world that
runs alone."""

from __future__ import annotations

import contextlib
import os
import stat
import time
from pathlib import Path

GIVEN_UP_S = 1.0
"""Creating a segment takes a millisecond; one that is incomplete for this long is abandoned."""
SEGMENTS = Path("/dev/shm")
"""Where Linux keeps named shared-memory segments."""


def remove_segments(prefix: str, folder: Path) -> bool:
    """Removes abandoned segments; returns whether some are, or may be, under construction.

    Call it before iceoryx2 cleans up dead nodes: it waits without end for a segment that is still
    empty.

    Anyone may put files there. Those that belong neither to this user nor to the owner of the
    processes' common folder are not a robot's.

    * `prefix`: prefix of the names of the robot's segments
    * `folder`: folder in which the robot's processes meet
    """
    owners = {os.geteuid()}
    with contextlib.suppress(OSError):
        owners.add(folder.stat().st_uid)
    being_made = False
    for entry in os.scandir(SEGMENTS):
        if not entry.name.startswith(prefix):
            continue
        try:
            found = entry.stat(follow_symlinks=False)
            is_made = found.st_size > 0 and found.st_mode & stat.S_IRUSR
            if is_made or found.st_uid not in owners:
                continue
            if time.time() - found.st_mtime > GIVEN_UP_S:
                Path(entry.path).unlink()
            else:
                being_made = True
        except FileNotFoundError:
            # It was removed meanwhile, so it is not half created.
            continue
        except OSError:
            being_made = True
    return being_made
