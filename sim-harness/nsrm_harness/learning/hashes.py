"""Computes the two hashes of a model file: of its whole content, and of what its results depend on.

`docs/decisions/core.md` defines the rule; `weights-codegen/src/hash.rs` implements it for the
loader, and `tests/golden/hash.json` has an example for both.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np

HASH = "hash"
"""The metadata entry that holds the file's hash."""
TOLD = ("training", "metrics")
"""Entries about training and metrics, on which no plan depends."""


def file_hash(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> str:
    """The hash of the whole content of the file, except the hash itself."""
    return _digest(tensors, metadata, (HASH,))


def identity(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> str:
    """The hash of all that the model's results depend on."""
    return _digest(tensors, metadata, (HASH, *TOLD))


def _digest(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, str], left_out: tuple[str, ...]
) -> str:
    digest = hashlib.sha256()

    def number(value: int) -> None:
        digest.update(value.to_bytes(8, "little"))

    def text(value: str) -> None:
        """Hashes the length first, so that boundaries between texts count."""
        content = value.encode()
        number(len(content))
        digest.update(content)

    entries = {key: value for key, value in metadata.items() if key not in left_out}
    number(len(entries))
    for key in sorted(entries):
        text(key)
        text(entries[key])
    number(len(tensors))
    for name in sorted(tensors):
        array = tensors[name]
        text(name)
        number(array.ndim)
        for dimension in array.shape:
            number(dimension)
        digest.update(np.ascontiguousarray(array, "<f4").tobytes())
    return digest.hexdigest()
