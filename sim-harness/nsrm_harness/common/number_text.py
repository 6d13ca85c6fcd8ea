"""Figures for a person."""

from __future__ import annotations


def or_dash(value: float | None, spec: str, *, times: float = 1.0, unit: str = "") -> str:
    """A figure as `format` has it, with its unit; a dash where there is none."""
    return "-" if value is None else f"{times * value:{spec}}{unit}"
