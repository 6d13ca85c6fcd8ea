"""Converts files of the previous schema, whose hash covered only the tensors."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from nsrm_harness.learning import export
from nsrm_harness.learning.baseline import file as baseline
from nsrm_harness.learning.export import ModelFileError, hashed_bytes, read_raw, write_whole

NEXT = dict(zip(export.CONVERTIBLE, (str(export.SCHEMA), baseline.SCHEMA), strict=True))
"""The current schema for each one that can be converted."""


def convert(path: Path) -> None:
    """Gives a file the current schema and hash; nothing else in it changes.

    Raises `ModelFileError` for a file of another schema, or whose tensors do not have its hash. The
    metadata are taken as they are, since nothing protected them.
    """
    arrays, metadata = read_raw(path)
    found = metadata.get("schema")
    if found not in NEXT:
        known = " or ".join(NEXT)
        raise ModelFileError(f"{path}: expected a file of schema {known} to convert, got {found}")
    if metadata.get("hash") != tensor_hash(arrays):
        raise ModelFileError(
            f"{path}: the tensors do not have the hash given in the file: it was changed or "
            "damaged, fetch it again"
        )
    write_whole(path, hashed_bytes(arrays, metadata | {"schema": NEXT[found]}))


def tensor_hash(tensors: Mapping[str, np.ndarray]) -> str:
    """The hash in those schemas: over the tensors by name, without metadata."""
    digest = hashlib.sha256()
    for name in sorted(tensors):
        array = tensors[name]
        digest.update(name.encode())
        digest.update(np.asarray(array.shape, "<u8").tobytes())
        digest.update(np.ascontiguousarray(array, "<f4").tobytes())
    return digest.hexdigest()
