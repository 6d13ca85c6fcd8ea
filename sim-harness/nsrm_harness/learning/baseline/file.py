"""Writes and reads the baseline's file, `baseline.safetensors`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax

from nsrm_harness import domain as domains
from nsrm_harness.common.json_text import json_text
from nsrm_harness.domain import Domain
from nsrm_harness.learning.baseline.model import Baseline
from nsrm_harness.learning.baseline.words import vocabulary
from nsrm_harness.learning.export import arrays_of, filled, hashed_bytes, read_checked, write_whole

SCHEMA = "baseline 2"
"""Not a number, so that the file cannot be confused with a model file."""


@dataclass(frozen=True)
class BaselineFile:
    """A baseline with the metadata of its file."""

    model: Baseline
    domain: Domain
    training: Mapping[str, Any] = field(default_factory=dict)
    """Seed, number of episodes, hash of the data, configuration."""
    metrics: Mapping[str, Any] = field(default_factory=dict)
    """Metrics on test; empty until evaluated."""


def write_baseline(path: Path, file: BaselineFile) -> None:
    """Writes the file atomically; the same baseline gives the same bytes."""
    metadata = {
        "schema": SCHEMA,
        "domain": file.domain.as_json(),
        "training": json_text(file.training),
        "metrics": json_text(file.metrics),
    }
    write_whole(path, hashed_bytes(arrays_of(file.model), metadata))


def read_baseline(path: Path) -> BaselineFile:
    """Reads the file. Raises `ModelFileError` with the problem."""
    arrays, metadata = read_checked(path, SCHEMA)
    domain = domains.from_json(metadata["domain"], str(path))
    return BaselineFile(
        model=filled(lambda: Baseline(vocabulary(domain), jax.random.key(0)), arrays, path),
        domain=domain,
        training=json.loads(metadata["training"]),
        metrics=json.loads(metadata["metrics"]),
    )
