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


def remove_segments(prefix: str, folder: Path) -> bool:
    """Removes segments that were begun and given up; whether some are being made, or may be.

    To be called before iceoryx2 looks at what the dead have left: it waits without end for a
    segment that is still empty.

    Anyone may put files there. Those of others than this user and who owns the folder in which
    the processes meet are none of a robot's.

    * `prefix`: what the names of the robot's segments begin with
    * `folder`: in which the robot's processes meet
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
            # What has gone meanwhile is not half made.
            continue
        except OSError:
            being_made = True
    return being_made
