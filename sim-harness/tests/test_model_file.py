"""Model files: their content cannot change unnoticed, and files of the previous
schema are converted."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import jax
import nsrm
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.learning import hashes
from nsrm_harness.learning.baseline import file as baseline
from nsrm_harness.learning.convert import convert, tensor_hash
from nsrm_harness.learning.export import (
    ModelFile,
    ModelFileError,
    Thresholds,
    WorkSpace,
    identity_of,
    read_checked,
    read_model,
    read_raw,
    safetensors_bytes,
    stored_camera,
    write_metrics,
    write_model,
)
from nsrm_harness.learning.hashes import file_hash
from nsrm_harness.learning.model import ACCEPTED, Dimensions, Model

ROOT = Path(__file__).resolve().parents[2]
COMMITTED = ROOT / "weights-codegen/tabletop/tabletop.safetensors"
EXAMPLE = ROOT / "tests" / "golden" / "hash.json"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A file of a model that has learned nothing."""
    path, domain = tmp_path / "model.safetensors", domains.load()
    model = Model(Dimensions.of(domain), jax.random.key(0))
    space = WorkSpace((0.3, -0.2, 0.0), (0.6, 0.2, 0.2))
    told = {"training": {"seed": 0}, "metrics": {"program": 0.5}}
    write_model(path, ModelFile(model, domain, Thresholds(0.4, 0.6), space, **told))
    return path


def changed(path: Path, change: Callable[[dict[str, str]], object]) -> None:
    """Change the metadata and nothing else."""
    arrays, metadata = read_raw(path)
    change(metadata)
    path.write_bytes(safetensors_bytes(arrays, metadata))


def test_the_golden_example_has_its_hashes() -> None:
    example = json.loads(EXAMPLE.read_text(encoding="utf-8"))
    tensors = {
        name: np.array(values, np.float32).reshape(shape)
        for name, (shape, values) in example["tensors"].items()
    }
    assert hashes.file_hash(tensors, example["metadata"]) == example["hash"]
    assert hashes.identity(tensors, example["metadata"]) == example["identity"]


def test_every_entry_of_the_metadata_is_covered(path: Path) -> None:
    content = path.read_bytes()
    _, metadata = read_raw(path)
    entries = {key: value for key, value in metadata.items() if key not in ("schema", "hash")}
    assert len(entries) == 9
    for key, value in entries.items():
        for at in (0, len(value) // 2, len(value) - 1):
            other = value[:at] + chr(ord(value[at]) ^ 1) + value[at + 1 :]
            path.write_bytes(content)
            changed(path, lambda metadata: metadata.update({key: other}))  # noqa: B023
            with pytest.raises(ModelFileError, match="changed or damaged, fetch it again"):
                read_model(path)
        path.write_bytes(content)
        changed(path, lambda metadata: metadata.pop(key))  # noqa: B023
        with pytest.raises(ModelFileError, match="changed or damaged"):
            read_model(path)


def test_the_order_of_entries_is_free(path: Path) -> None:
    content = path.read_bytes()
    arrays, metadata = read_raw(path)
    other = {key: metadata[key] for key in sorted(metadata, reverse=True)}
    path.write_bytes(safetensors_bytes(arrays, other))
    assert path.read_bytes() != content
    assert read_checked(path, "9")[1] == metadata


def test_new_metrics_give_a_new_hash_and_the_same_identity(path: Path) -> None:
    before, (_, said) = identity_of(read_model(path)), read_raw(path)
    write_metrics(path, {"program": 0.75})
    assert read_model(path).metrics == {"program": 0.75}
    assert read_raw(path)[1]["hash"] != said["hash"]
    assert identity_of(read_model(path)) == before
    assert nsrm.Model.load(path).info()["identity"] == before


@pytest.mark.parametrize(
    "key", ["domain", "thresholds", "work_space", "placed_orientation", "training_camera"]
)
def test_what_plans_depend_on_gives_another_identity(path: Path, key: str) -> None:
    arrays, metadata = read_raw(path)
    before = hashes.identity(arrays, metadata)
    assert hashes.identity(arrays, metadata | {key: metadata[key] + " "}) != before
    arrays["camera.weight"] = arrays["camera.weight"] + np.float32(1.0)
    assert hashes.identity(arrays, metadata) != before


def test_the_committed_model_is_the_cores() -> None:
    expected = hashes.identity(*read_checked(COMMITTED, "9"))
    assert identity_of(read_model(COMMITTED)) == expected
    for model in (nsrm.Model.pretrained(), nsrm.Model.load(COMMITTED)):
        assert model.info()["identity"] == expected


SEEN = "language.splitter.hidden.weight"
HASHED_WHOLE = ("3", "4", "5", "6", "7", "8")
"""Schemas whose hash covers the metadata, too."""


def as_before(path: Path, schema: str) -> None:
    """The file as an earlier schema had it."""
    arrays, metadata = read_raw(path)
    if schema not in ("baseline 1", "8"):
        for name in ("language.relation_decoder.weight", "language.relation_decoder.bias"):
            # Without superlatives.
            half = len(arrays[name]) // 2
            of_actions = [*range(half - 2), *range(half, 2 * half - 2)]
            arrays[name] = arrays[name][of_actions]
    if schema not in ("baseline 1", "7", "8"):
        metadata.pop("training_camera")
        known = {"6": 2, "5": 2, "4": 1}.get(schema, 0)
        added = ["acceptability", "relation_decoder"][known:]
        arrays = {
            name: array for name, array in arrays.items() if not any(part in name for part in added)
        }
        if schema != "6":
            arrays[SEEN] = arrays[SEEN][:, : 32 + 2 * 24]
    metadata |= {"schema": schema}
    covered = file_hash(arrays, metadata) if schema in HASHED_WHOLE else tensor_hash(arrays)
    path.write_bytes(safetensors_bytes(arrays, metadata | {"hash": covered}))


@pytest.mark.parametrize("schema", ["2", "3", "4", "5", "6", "7", "8"])
def test_a_file_of_an_earlier_schema_is_refused_until_it_is_converted(
    path: Path, schema: str
) -> None:
    as_before(path, schema)
    with pytest.raises(ModelFileError, match=f"schema 9, got {schema}: convert it with"):
        read_model(path)
    with pytest.raises(nsrm.ModelError, match="cargo harness convert"):
        nsrm.Model.load(path)
    convert(path)
    arrays, _ = read_checked(path, "9")
    assert arrays["language.acceptability.output.bias"] == ACCEPTED
    assert not arrays["language.acceptability.output.weight"].any()
    assert (arrays["language.relation_decoder.bias"] == -ACCEPTED).all()
    assert not arrays["language.relation_decoder.weight"].any()
    assert arrays[SEEN].shape == (32, 32 + 6 * 24)
    assert schema in ("6", "7", "8") or not arrays[SEEN][:, 32 + 2 * 24 :].any()
    assert read_model(path).training_camera == stored_camera()
    nsrm.Model.load(path)
    with pytest.raises(
        ModelFileError, match="schema 2, 3, 4, 5, 6, 7, 8 or baseline 1 to convert, got 9"
    ):
        convert(path)


def test_a_converted_model_knows_the_relations_that_it_knew(tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    path.write_bytes(COMMITTED.read_bytes())
    before = read_raw(path)[0]
    as_before(path, "7")
    convert(path)
    after = read_checked(path, "9")[0]
    for name in ("language.relation_decoder.weight", "language.relation_decoder.bias"):
        (restricts, stands), (of, for_) = np.split(after[name], 2), np.split(before[name], 2)
        assert (restricts[:5] == of[:5]).all() and (stands[:5] == for_[:5]).all()
        untaught = 0.0 if name.endswith("weight") else -ACCEPTED
        assert (restricts[5:] == untaught).all() and (stands[5:] == untaught).all()
    assert nsrm.Model.load(path).info()["relations"] == [
        *("MoveOn", "MoveRight", "MoveLeft", "MoveFront", "MoveBehind")
    ]


def test_a_baselines_file_is_converted(path: Path) -> None:
    as_before(path, "baseline 1")
    with pytest.raises(ModelFileError, match="schema baseline 2, got baseline 1: convert it"):
        read_checked(path, baseline.SCHEMA)
    convert(path)
    assert read_checked(path, baseline.SCHEMA)[1]["schema"] == baseline.SCHEMA


def test_a_damaged_file_is_not_converted(path: Path) -> None:
    as_before(path, "2")
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    with pytest.raises(ModelFileError, match="does not have the hash"):
        convert(path)
    assert path.read_bytes() == content
