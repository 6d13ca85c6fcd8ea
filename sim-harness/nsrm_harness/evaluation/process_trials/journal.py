"""The journal of a trial: one line of JSON per event."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import HarnessError

Line = Mapping[str, Any]
"""`t`: nanoseconds on the machine's monotonic clock; `who` wrote the line; `what` happened; and
fields of that kind of event."""


class JournalError(HarnessError):
    """A journal that cannot be read."""


def read(path: Path) -> list[Line]:
    """The lines of a journal, sorted by time. Raises `JournalError`."""
    lines: list[Line] = []
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise JournalError(f"{path}: {error.strerror}") from error
    for number, line in enumerate(text.splitlines(), 1):
        try:
            lines.append(json.loads(line))
        except json.JSONDecodeError as error:
            raise JournalError(f"{path}: line {number}: invalid JSON: {error}") from error
    return sorted(lines, key=lambda line: line["t"])
