"""JSON as all of the harness writes it: without NaN and infinities, which strict readers refuse.

`json.dumps` writes them bare unless it is told not to; ruff allows it here alone.
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
    """As `json.dumps`. Raises `ValueError` for a number that is not finite, and says where it is;
    what is absent is None."""
    if where := _not_finite(content, ""):
        raise ValueError(f"{where}, which JSON does not have: give None, or leave it out")
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
