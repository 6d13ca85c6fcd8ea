"""The command ``harness``, run in the test's process."""

from __future__ import annotations

from pathlib import Path

import pytest

from nsrm_harness.cli.main import main


def run(*arguments: str | int | Path) -> int:
    """The exit code of ``harness`` with these arguments."""
    with pytest.raises(SystemExit) as caught:
        main([str(argument) for argument in arguments])
    return caught.value.code if isinstance(caught.value.code, int) else 0
