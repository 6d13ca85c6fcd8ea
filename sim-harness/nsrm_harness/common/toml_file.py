"""Checks TOML files with pydantic against frozen dataclasses; errors name file, key and fault.

A dataclass that a file fills rejects unknown keys with `__pydantic_config__ = NO_OTHER_KEYS`. Its
types define the allowed values: `Text`, `Positive` and so on, tuples for lists. Our own validators
raise a `ValueError` whose message gives the problem, the actual and the expected value.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from nsrm_harness.common.errors import HarnessError

Filled = TypeVar("Filled")

NO_OTHER_KEYS = ConfigDict(extra="forbid")

LEAST = 1e-9
"""Smallest value of a number that must be above 0."""

# Strict: true is not a number, 1.0 is not an integer, "1" is neither.
Text = Annotated[str, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Count = Annotated[Whole, Field(ge=1)]
CountOrZero = Annotated[Whole, Field(ge=0)]
Positive = Annotated[Number, Field(ge=LEAST)]
PositiveOrZero = Annotated[Number, Field(ge=0.0)]

UNKNOWN_KEY = "unexpected_keyword_argument"
"""Pydantic's type of this error."""


def _unknown_key(_: Any) -> Any:
    raise PydanticCustomError(UNKNOWN_KEY, "unknown key")


Derived = Annotated[
    str, Field(default="", json_schema_extra={"readOnly": True}), BeforeValidator(_unknown_key)
]
"""A text that the reader fills in, and that no file may contain."""

_SHOWN = 80
"""Largest number of characters of the actual value that is shown."""
_FAULTS = {
    "missing": "is missing",
    "dataclass_type": "expected a table, got {got}",
    "dict_type": "expected a table, got {got}",
    "mapping_type": "expected a table, got {got}",
    "tuple_type": "expected a list, got {got}",
    "too_short": "expected {min_length} or more entries, got {got}",
    "too_long": "expected {max_length} or fewer entries, got {got}",
    "bool_type": "expected true or false, got {got}",
    "greater_than_equal": "must be at least {ge:g}, got {got}",
    "less_than_equal": "must be at most {le:g}, got {got}",
    "literal_error": "expected {expected}, got {got}",
    "value_error": "{error}",
    UNKNOWN_KEY: "unknown key; expected some of: {known}",
}
"""Messages by pydantic's type of error; other types use its message and the actual value."""


def read_toml(path: Path, error: type[HarnessError], what: str) -> dict[str, Any]:
    """The file's content; `what` names the kind of file in errors."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as cause:
        raise error(f"{path}: cannot read the {what}: {cause}") from cause
    except tomllib.TOMLDecodeError as cause:
        raise error(f"{path}: not TOML: {cause}") from cause


def checked(
    kind: type[Filled], content: Mapping[str, Any], source: str, error: type[HarnessError]
) -> Filled:
    """The dataclass filled with the content of a file; `source` names the file in errors."""
    try:
        return _adapter(kind).validate_python(content)
    except ValidationError as cause:
        details = cause.errors(include_url=False)
        deep = {loc[:end] for loc in (each["loc"] for each in details) for end in range(len(loc))}
        # Pydantic does not count invalid entries; their faults are reported deeper.
        faults = [
            (_dotted(each["loc"]), _fault(kind, each))
            for each in details
            if each["type"] != "too_short" or each["loc"] not in deep
        ]
        raise refusal(source, faults, error) from None


def refusal(
    source: str, faults: Iterable[tuple[str, str]], error: type[HarnessError]
) -> HarnessError:
    """The error to raise: one line per fault, with file, dotted key and problem."""
    return error("\n".join(f"{source}: {key}: {fault}" for key, fault in faults))


@cache
def _adapter(kind: type[Filled]) -> TypeAdapter[Filled]:
    return TypeAdapter(kind)


def _dotted(place: tuple[int | str, ...]) -> str:
    """A place in dotted form, such as `attribute[0].values[1].rgb`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    return "".join(parts).removeprefix(".")


def _fault(kind: Any, details: ErrorDetails) -> str:
    got = repr(details["input"])
    got = got if len(got) <= _SHOWN else f"{got[:_SHOWN]}…"
    words = _FAULTS.get(details["type"])
    if words is None:
        return f"{details['msg'].removeprefix('Input ')}, got {got}"
    known = _known_keys(kind, details["loc"]) if details["type"] == UNKNOWN_KEY else ""
    return words.format(**details.get("ctx", {}), got=got, known=known)


def _known_keys(kind: Any, place: tuple[int | str, ...]) -> str:
    """The keys that are allowed in the table with an unknown key."""
    schema = table = _adapter(kind).json_schema()
    for part in place[:-1]:
        table = table["items"] if isinstance(part, int) else table["properties"][part]
        # In optional values the first alternative is not null.
        table = table.get("anyOf", [table])[0]
        if "$ref" in table:
            table = schema["$defs"][table["$ref"].removeprefix("#/$defs/")]
    keys = table["properties"].items()
    return ", ".join(sorted(key for key, values in keys if "readOnly" not in values))
