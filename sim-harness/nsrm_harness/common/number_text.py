"""Formats figures for people."""

from __future__ import annotations


def or_dash(value: float | None, spec: str, *, times: float = 1.0, unit: str = "") -> str:
    """A figure formatted by `format`, with its unit; a dash for None."""
    return "-" if value is None else f"{times * value:{spec}}{unit}"
