"""The messages have the same memory layout in Python as in Rust."""

import ctypes
import inspect
from typing import Any

import pytest

from nsrm_harness.nodes import messages

CLASSES: list[Any] = [
    found
    for _, found in inspect.getmembers(messages, inspect.isclass)
    if issubclass(found, ctypes.Structure)
]


@pytest.mark.parametrize("message", CLASSES, ids=lambda message: message.__name__)
def test_size_alignment_and_every_offset_are_rusts(message: Any) -> None:
    assert (ctypes.sizeof(message), ctypes.alignment(message)) == message.LAYOUT
    offsets = {name: getattr(message, name).offset for name, *_ in message._fields_}
    assert offsets == message.OFFSETS
    assert message.type_name().startswith(f"nsrm.v1.{message.__name__}.")


def test_there_are_messages() -> None:
    assert len(CLASSES) == 12
