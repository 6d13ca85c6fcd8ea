"""Patterns (the tokens of a step without the attribute values), and which are kept from training.

The trainer makes steps that the model must refuse, and the test sets of sentences to refuse come
from the same grammar. A quarter of all patterns is reserved for those sets, so that they measure
only what was never trained on.
"""

from __future__ import annotations

from collections.abc import Iterable

HASH_BASE = 2_654_435_761
"""Odd, so that every token affects the 32 bits."""
RESERVED_SHIFT = 30
"""The upper two bits of a reserved pattern's hash are 0: one pattern in four."""


def pattern_hash(rows: Iterable[int]) -> int:
    """Hash of a step's tokens, given as rows of the embeddings; 32 bits.

    `learning.nonsense.is_reserved` does the same for arrays.
    """
    power, total = HASH_BASE, 0
    for row in rows:
        total += (row + 1) * power
        power = power * HASH_BASE % 2**32
    return total % 2**32


def is_reserved(rows: Iterable[int]) -> bool:
    """Whether a step with these tokens is kept from training."""
    return pattern_hash(rows) >> RESERVED_SHIFT == 0
