"""Converts files of earlier schemas: the hash covered only the tensors (model 2, baseline 1), and
models had no acceptability (2, 3), no relations in descriptions (2 to 4), a splitter that saw two
tokens ahead (2 to 5), did not tell the camera of their training (2 to 6), had no superlatives in
descriptions (2 to 7), and no extremes (2 to 8)."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import jax
import numpy as np

from nsrm_harness.common.json_text import json_text
from nsrm_harness.domain.program import SUPERLATIVES
from nsrm_harness.learning import export, hashes
from nsrm_harness.learning.baseline import file as baseline
from nsrm_harness.learning.export import ModelFileError, hashed_bytes, read_raw, write_whole
from nsrm_harness.learning.model import (
    LOOKAHEAD,
    SPLITTER_HIDDEN,
    SPLITTER_WORD,
    Acceptability,
    tensors,
    without_relations,
)

BASELINE = "baseline 1"
NEXT = {
    schema: baseline.SCHEMA if schema == BASELINE else str(export.SCHEMA)
    for schema in export.CONVERTIBLE
}
"""The current schema for each one that can be converted."""
WITHOUT_SUPERLATIVES = ("2", "3", "4", "5", "6", "7")
"""Schemas whose descriptions have none."""
LAST_OF_TENSORS = ("2", BASELINE)
"""Schemas whose hash covers only the tensors."""


def convert(path: Path) -> None:
    """Gives a file the current schema and hash, and a model that has none an acceptability with
    which it accepts all words that it accepted before, a relation decoder that finds no other
    relations than before, a splitter that ignores the tokens that it did not see before, and the
    default camera, with which all of them were trained; nothing else in it changes.

    Raises `ModelFileError` for a file of another schema, or which does not have its hash. The
    metadata of the first schemas are taken as they are, since nothing protected them.
    """
    arrays, metadata = read_raw(path)
    found = metadata.get("schema")
    if found not in NEXT:
        *others, last = NEXT
        known = f"{', '.join(others)} or {last}"
        raise ModelFileError(f"{path}: expected a file of schema {known} to convert, got {found}")
    covered = (
        tensor_hash(arrays) if found in LAST_OF_TENSORS else hashes.file_hash(arrays, metadata)
    )
    if metadata.get(hashes.HASH) != covered:
        raise ModelFileError(
            f"{path}: it does not have the hash given in the file: it was changed or damaged, "
            "fetch it again"
        )
    if found != BASELINE:
        actions = len(arrays["language.action_decoder.bias"])
        added = {
            "acceptability": Acceptability(jax.random.key(0)),
            "relation_decoder": without_relations(actions),
        }
        arrays = {
            f"language.{part}.{name}": np.asarray(array)
            for part, module in added.items()
            for name, array in tensors(module).items()
        } | arrays
        superlatives = len(SUPERLATIVES) if found in WITHOUT_SUPERLATIVES else 0
        for name, array in tensors(without_relations(superlatives)).items():
            rows = f"language.relation_decoder.{name}"
            old, new = np.split(arrays[rows], 2), np.split(np.asarray(array), 2)
            arrays[rows] = np.concatenate([old[0], new[0], old[1], new[1]])
        seen = arrays["language.splitter.hidden.weight"]
        unseen = SPLITTER_HIDDEN + LOOKAHEAD * SPLITTER_WORD - seen.shape[1]
        arrays["language.splitter.hidden.weight"] = np.pad(seen, ((0, 0), (0, unseen)))
        metadata = {"training_camera": json_text(asdict(export.stored_camera()))} | metadata
    write_whole(path, hashed_bytes(arrays, metadata | {"schema": NEXT[found]}))


def tensor_hash(tensors: Mapping[str, np.ndarray]) -> str:
    """The hash in the first schemas: over the tensors by name, without metadata."""
    digest = hashlib.sha256()
    for name in sorted(tensors):
        array = tensors[name]
        digest.update(name.encode())
        digest.update(np.asarray(array.shape, "<u8").tobytes())
        digest.update(np.ascontiguousarray(array, "<f4").tobytes())
    return digest.hexdigest()
