"""The model file: safetensors with everything that inference needs in its metadata.

The file is written here rather than by the safetensors package, which orders metadata at random:
the same model must give the same bytes. It is read back through that package.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np
from safetensors import SafetensorError, safe_open

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.domain import Domain
from nsrm_harness.learning import hashes
from nsrm_harness.learning import model as network
from nsrm_harness.learning.model import Dimensions, Model, Network

SCHEMA = 3
"""Version of the model file, `nsrm_core::model::SCHEMA`."""
CONVERTIBLE = ("2", "baseline 1")
"""Schemas whose files differ from today's in the hash alone; `convert.py` takes them."""


class ModelFileError(HarnessError):
    """A model file that cannot be read."""


@dataclass(frozen=True)
class Thresholds:
    """When to refuse rather than guess."""

    match_score: float
    """Least filtered cosine of an object that matches a description."""
    decision: float
    """Least probability of a split, an action or an argument that is acted on."""


@dataclass(frozen=True)
class WorkSpace:
    """Where sub-goals may lie: world frame, metres, bounds included."""

    min: tuple[float, float, float]
    max: tuple[float, float, float]


@dataclass(frozen=True)
class ModelFile:
    """A model with what its file says of it."""

    model: Model
    domain: Domain
    thresholds: Thresholds
    work_space: WorkSpace
    placed_orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    """In which the demonstrator sets objects down: x, y, z, w."""
    training: Mapping[str, Any] = field(default_factory=dict)
    """Seed, number of episodes, hash of the data, stages."""
    metrics: Mapping[str, Any] = field(default_factory=dict)
    """On test, by `evaluate.py`; empty until evaluated."""


def arrays_of(model: eqx.Module) -> dict[str, np.ndarray]:
    """Every tensor of the model as float32; raises where one is not finite."""
    arrays = {name: np.asarray(a, np.float32) for name, a in network.tensors(model).items()}
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has values that are not finite: the training diverged")
    return arrays


def model_bytes(file: ModelFile) -> bytes:
    """The file's content; the same model gives the same bytes. Raises `ModelFileError` for a
    simulator that the core does not know."""
    if not file.model.action.simulator.residual:
        raise ModelFileError("a model whose simulator has no residual cannot be exported")
    return hashed_bytes(arrays_of(file.model), metadata_of(file))


def identity_of(file: ModelFile) -> str:
    """What the core ties scenes to the model by: SHA-256 of all that its results depend on."""
    return hashes.identity(arrays_of(file.model), metadata_of(file))


def metadata_of(file: ModelFile) -> dict[str, str]:
    """What the file says besides its tensors and its hash."""
    sizes = {
        "word": network.WORD,
        "encoder_hidden": network.ENCODER_HIDDEN,
        "splitter_word": network.SPLITTER_WORD,
        "splitter_hidden": network.SPLITTER_HIDDEN,
        "crop": network.CROP,
        "patch_channels": network.PATCH_CHANNELS,
        "merge_channels": network.MERGE_CHANNELS,
        "view_embedding": network.VIEW_EMBEDDING,
        "operator_hidden": network.OPERATOR_HIDDEN,
        "concept": network.CONCEPT,
        "simulator_hidden": network.SIMULATOR_HIDDEN,
    }
    return {
        "schema": str(SCHEMA),
        "domain": file.domain.as_json(),
        "vocabulary": json_text(file.domain.vocabulary(), ensure_ascii=False),
        "dimensions": json_text(sizes),
        "thresholds": json_text(asdict(file.thresholds)),
        "work_space": json_text(asdict(file.work_space)),
        "placed_orientation": json_text(file.placed_orientation),
        "training": json_text(file.training),
        "metrics": json_text(file.metrics),
    }


def hashed_bytes(arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> bytes:
    """A safetensors file with the hash over its tensors and metadata in it, sorted by key."""
    named = {**metadata, hashes.HASH: hashes.file_hash(arrays, metadata)}
    return safetensors_bytes(arrays, dict(sorted(named.items())))


def safetensors_bytes(arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> bytes:
    """Tensors sorted by name and metadata in the given order as a safetensors file."""
    header: dict[str, Any] = {"__metadata__": dict(metadata)}
    dtypes = {"float32": "F32", "uint8": "U8", "int32": "I32"}
    content = bytearray()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        start = len(content)
        content += array.astype(array.dtype.newbyteorder("<")).tobytes()
        header[name] = {
            "dtype": dtypes[array.dtype.name],
            "shape": list(arrays[name].shape),
            "data_offsets": [start, len(content)],
        }
    text = json_text(header, ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    return len(text).to_bytes(8, "little") + text + bytes(content)


def write_model(path: Path, file: ModelFile) -> None:
    """Write the model file, all of it or nothing."""
    write_whole(path, model_bytes(file))


def write_whole(path: Path, content: bytes) -> None:
    """Write a file, all of it or nothing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".part")
    partial.write_bytes(content)
    partial.replace(path)


def read_model(path: Path) -> ModelFile:
    """Read a model file back; `ModelFileError` says what does not fit."""
    arrays, metadata = read_checked(path, str(SCHEMA))
    domain = domains.from_json(metadata["domain"], str(path))
    model = filled(lambda: Model(Dimensions.of(domain), jax.random.key(0)), arrays, path)
    space = json.loads(metadata["work_space"])
    return ModelFile(
        model=model,
        domain=domain,
        thresholds=Thresholds(**json.loads(metadata["thresholds"])),
        work_space=WorkSpace(tuple(space["min"]), tuple(space["max"])),
        placed_orientation=tuple(json.loads(metadata["placed_orientation"])),
        training=json.loads(metadata["training"]),
        metrics=json.loads(metadata["metrics"]),
    )


def read_raw(path: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Tensors and metadata of a file, whatever it is."""
    try:
        with safe_open(path, framework="numpy") as reader:
            metadata = dict(reader.metadata() or {})
            arrays = {name: reader.get_tensor(name) for name in reader.keys()}  # noqa: SIM118
    except (OSError, SafetensorError) as error:
        raise ModelFileError(f"{path}: cannot read the model file: {error}") from error
    return arrays, metadata


def read_checked(path: Path, schema: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Tensors and metadata of a file of that schema which has the hash that it names."""
    arrays, metadata = read_raw(path)
    if (found := metadata.get("schema")) != schema:
        convert = "convert it with 'cargo harness convert', or " if found in CONVERTIBLE else ""
        raise ModelFileError(
            f"{path}: expected a model file of schema {schema}, got {found}: {convert}train again"
        )
    if metadata.get(hashes.HASH) != hashes.file_hash(arrays, metadata):
        raise ModelFileError(
            f"{path}: metadata and tensors do not have the hash given in the file: it was changed "
            "or damaged, fetch it again or export the model again"
        )
    return arrays, metadata


def filled(make: Callable[[], Network], arrays: Mapping[str, np.ndarray], path: Path) -> Network:
    """The network that is made, with the tensors of a file; names and shapes must be its own.

    Its own weights are never drawn: a process would compile that for many seconds.
    """
    empty = jax.tree.map(
        lambda leaf: (
            jax.numpy.asarray(np.zeros(leaf.shape, leaf.dtype))
            if isinstance(leaf, jax.ShapeDtypeStruct)
            else leaf
        ),
        eqx.filter_eval_shape(make),
    )
    try:
        values = {name: jax.numpy.asarray(array) for name, array in arrays.items()}
        return network.with_tensors(empty, values)
    except ValueError as error:
        raise ModelFileError(f"{path}: {error}") from error


def write_metrics(path: Path, metrics: Mapping[str, Any]) -> None:
    """Put the metrics on test into a model file, with the hash that it has then; its identity stays
    as it is."""
    write_model(path, replace(read_model(path), metrics=metrics))
