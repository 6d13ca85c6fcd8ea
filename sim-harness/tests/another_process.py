"""Runs a function in another process, to compare its results."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parent


def elsewhere(code: str, **variables: str) -> str:
    """What another process prints, to which strings are hashed otherwise.

    * `variables`: of its environment, besides this one's
    """
    paths = os.pathsep.join([str(TESTS.parent), str(TESTS)])
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": paths, "PYTHONHASHSEED": "1", **variables},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()
