"""Writes and reads the model file: safetensors with everything that inference needs in its
metadata.

The file is written here and not by the safetensors package, whose order of metadata is random: the
same model must give the same bytes. It is read with that package.
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
from nsrm_harness.common.whole_file import write_whole
from nsrm_harness.data.file import camera_from_row, camera_row
from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.learning import hashes
from nsrm_harness.learning import model as network
from nsrm_harness.learning.model import Dimensions, Model, Network

SCHEMA = 9
"""Version of the model file, `nsrm_core::model::SCHEMA`."""
CONVERTIBLE = ("2", "3", "4", "5", "6", "7", "8", "baseline 1")
"""Schemas whose files differ from the current one only in the hash; see `convert.py`."""


class ModelFileError(HarnessError):
    """A model file that cannot be read."""


@dataclass(frozen=True)
class Thresholds:
    """Thresholds below which the core refuses instead of guessing."""

    match_score: float
    """Smallest filtered cosine of an object that matches a description."""
    decision: float
    """Smallest probability of an accepted split, action or argument."""
    confidence: float | None = None
    """Smallest confidence of an accepted plan, if it was calibrated."""

    def as_json(self) -> dict[str, float]:
        """Those that are set."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class WorkSpace:
    """The workspace of sub-goals: world frame, metres, bounds included."""

    min: tuple[float, float, float]
    max: tuple[float, float, float]


def stored(camera: Camera) -> Camera:
    """The camera with the precision of episode files."""
    return camera_from_row(camera_row(camera), camera.width, camera.height)


def stored_camera() -> Camera:
    """The default camera with that precision."""
    return stored(default_camera())


def camera_from_json(text: str) -> Camera:
    """A camera in the metadata."""
    fields = json.loads(text)
    return Camera(**{name: _tupled(value) for name, value in fields.items()})


def _tupled(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


@dataclass(frozen=True)
class ModelFile:
    """A model with the metadata of its file."""

    model: Model
    domain: Domain
    thresholds: Thresholds
    work_space: WorkSpace
    placed_orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    """Orientation in which the demonstrator places objects: x, y, z, w."""
    training_camera: Camera = field(default_factory=stored_camera)
    """The camera that saw the demonstrations, in whose image the simulator predicts."""
    training: Mapping[str, Any] = field(default_factory=dict)
    """Seed, number of episodes, hash of the data, stages."""
    metrics: Mapping[str, Any] = field(default_factory=dict)
    """Metrics on test; empty until evaluated."""


def arrays_of(model: eqx.Module) -> dict[str, np.ndarray]:
    """Every tensor of the model as float32; raises `ValueError` if one is not finite."""
    arrays = {name: np.asarray(a, np.float32) for name, a in network.tensors(model).items()}
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has values that are not finite: the training diverged")
    return arrays


def model_bytes(file: ModelFile) -> bytes:
    """The content of the file; the same model gives the same bytes. Raises `ModelFileError` for a
    simulator that the core does not support."""
    if not file.model.action.simulator.residual:
        raise ModelFileError("a model whose simulator has no residual cannot be exported")
    return hashed_bytes(arrays_of(file.model), metadata_of(file))


def identity_of(file: ModelFile) -> str:
    """The model's identity, to which scenes are bound: SHA-256 of all that its
    results depend on."""
    return hashes.identity(arrays_of(file.model), metadata_of(file))


def metadata_of(file: ModelFile) -> dict[str, str]:
    """The metadata of the file, without the hash."""
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
        "thresholds": json_text(file.thresholds.as_json()),
        "work_space": json_text(asdict(file.work_space)),
        "placed_orientation": json_text(file.placed_orientation),
        "training_camera": json_text(asdict(file.training_camera)),
        "training": json_text(file.training),
        "metrics": json_text(file.metrics),
    }


def hashed_bytes(arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> bytes:
    """A safetensors file that contains the hash of its tensors and metadata, sorted by key."""
    named = {**metadata, hashes.HASH: hashes.file_hash(arrays, metadata)}
    return safetensors_bytes(arrays, dict(sorted(named.items())))


def safetensors_bytes(arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str]) -> bytes:
    """A safetensors file with tensors sorted by name and metadata in the given order."""
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
    """Writes the model file atomically."""
    write_whole(path, model_bytes(file))


def read_model(path: Path) -> ModelFile:
    """Reads a model file. Raises `ModelFileError` with the problem."""
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
        training_camera=camera_from_json(metadata["training_camera"]),
        training=json.loads(metadata["training"]),
        metrics=json.loads(metadata["metrics"]),
    )


def read_raw(path: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Tensors and metadata of any safetensors file."""
    try:
        with safe_open(path, framework="numpy") as reader:
            metadata = dict(reader.metadata() or {})
            arrays = {name: reader.get_tensor(name) for name in reader.keys()}  # noqa: SIM118
    except (OSError, SafetensorError) as error:
        raise ModelFileError(f"{path}: cannot read the model file: {error}") from error
    return arrays, metadata


def read_checked(path: Path, schema: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Tensors and metadata of a file, after checking its schema and hash."""
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
    """The network made by `make`, with the tensors of a file; names and shapes must match.

    Its random weights are never drawn: compiling that takes many seconds in each process.
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
    """Writes the metrics on test into a model file and updates its hash; its identity does not
    change."""
    write_model(path, replace(read_model(path), metrics=metrics))
