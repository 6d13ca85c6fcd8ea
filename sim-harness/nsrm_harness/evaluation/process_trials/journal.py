"""The journal of a trial: a line of JSON for each thing that happened."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import HarnessError

Line = Mapping[str, Any]
"""`t`: nanoseconds on the machine's monotonic clock; `who` wrote it; `what` happened; more."""


class JournalError(HarnessError):
    """A journal that can't be read."""


def read(path: Path) -> list[Line]:
    """The lines of a journal, by time. Raises `JournalError`."""
    lines: list[Line] = []
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise JournalError(f"{path}: {error.strerror}") from error
    for number, line in enumerate(text.splitlines(), 1):
        try:
            lines.append(json.loads(line))
        except json.JSONDecodeError as error:
            raise JournalError(f"{path}: line {number}: no JSON: {error}") from error
    return sorted(lines, key=lambda line: line["t"])
