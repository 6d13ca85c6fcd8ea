"""Writes JSON without NaN and infinities, which strict readers reject.

`json.dumps` writes them by default; ruff allows it only in this module.
"""

from __future__ import annotations

import json
import math
from typing import Any


def json_text(
    content: Any,
    *,
    indent: int | None = None,
    ensure_ascii: bool = True,
    sort_keys: bool = False,
    separators: tuple[str, str] | None = None,
) -> str:
    """Like `json.dumps`, but raises `ValueError` with the location of a number that is not finite.
    Use None for missing values."""
    if where := _not_finite(content, ""):
        raise ValueError(f"{where}, which JSON does not support: use None, or omit it")
    return json.dumps(  # noqa: TID251
        content,
        indent=indent,
        ensure_ascii=ensure_ascii,
        sort_keys=sort_keys,
        separators=separators,
        allow_nan=False,
    )


def _not_finite(content: Any, place: str) -> str | None:
    """The first number that is not finite, as in `errors[2] is nan`."""
    match content:
        case float() if not math.isfinite(content):
            return f"{place.removeprefix('.') or 'the content'} is {content}"
        case dict():
            parts = ((value, f"{place}.{key}") for key, value in content.items())
        case list() | tuple():
            parts = ((value, f"{place}[{index}]") for index, value in enumerate(content))
        case _:
            return None
    return next((found for part in parts if (found := _not_finite(*part))), None)
