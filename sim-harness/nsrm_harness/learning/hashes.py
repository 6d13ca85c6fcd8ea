"""The two hashes of a model file: over all that it says, and over what its results depend on.

The rule stands in `docs/decisions/core.md`; the loader's is `weights-codegen/src/hash.rs`, and
`tests/golden/hash.json` has an example for both.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np

HASH = "hash"
"""The metadata entry that holds the file's hash."""
TOLD = ("training", "metrics")
"""Entries that tell how the model came about and what it reached; no plan depends on them."""


def file_hash(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> str:
    """Over all that the file says, but for the hash itself."""
    return _digest(tensors, metadata, (HASH,))


def identity(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> str:
    """Over what the model's results depend on: the same whatever is told of it."""
    return _digest(tensors, metadata, (HASH, *TOLD))


def _digest(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, str], left_out: tuple[str, ...]
) -> str:
    digest = hashlib.sha256()

    def number(value: int) -> None:
        digest.update(value.to_bytes(8, "little"))

    def text(value: str) -> None:
        """Its length first: where one text ends and the next begins counts too."""
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
