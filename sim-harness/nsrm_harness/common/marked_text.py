"""Text between two marks of a page that people write and commands fill."""

from __future__ import annotations

from nsrm_harness.common.errors import HarnessError


class MarkError(HarnessError):
    """A page without one of its marks."""


def replaced(page: str, begin: str, block: str, end: str) -> str:
    """The page with other lines between its marks. Raises `MarkError`."""
    before, has_begin, rest = page.partition(begin)
    _, has_end, behind = rest.partition(end)
    if not has_begin or not has_end:
        raise MarkError(f"the page lacks a mark: {begin!r} or {end!r}")
    return f"{before}{begin}\n{block}\n{end}{behind}"
