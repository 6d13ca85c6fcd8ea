"""Speed that can't be measured."""

from __future__ import annotations

from nsrm_harness.errors import HarnessError


class SpeedError(HarnessError):
    """Workers that don't start, or episodes that do not end the same each time."""
