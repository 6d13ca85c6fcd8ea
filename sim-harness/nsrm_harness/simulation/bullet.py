"""Connects to PyBullet without its output on import and on connecting."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Redirects file descriptors 1 and 2 to nowhere, because the output comes from C."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [os.dup(1), os.dup(2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(saved[0], 1)
        os.dup2(saved[1], 2)
        for descriptor in (*saved, nowhere):
            os.close(descriptor)


with silenced():
    import pybullet


def connect_direct() -> int:
    """A new PyBullet client without a window. Raises `RuntimeError` if there is none."""
    with silenced():
        client = pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise RuntimeError("PyBullet cannot open another client: too many are open in this process")
    return client
