"""Writes the ONNX graphs of a model file, after comparing each with the trainer's model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.whole_file import write_whole
from nsrm_harness.learning import model as network
from nsrm_harness.learning.comparison.graphs import GRAPHS, OBJECTS, TOKENS, VARIANTS
from nsrm_harness.learning.comparison.jax_contender import FUNCTIONS
from nsrm_harness.learning.comparison.onnxruntime_contender import session
from nsrm_harness.learning.comparison.protocol import INPUTS
from nsrm_harness.learning.export import read_model
from nsrm_harness.learning.model import Model

TOLERANCE = 1e-4
"""Greatest difference between a graph's output and the model's; sizes are about 1."""
TRIALS = 20
"""Random inputs on which they are compared."""


class GraphError(HarnessError):
    """A graph that does not compute what the model does."""


def write_graphs(model_path: Path, folder: Path) -> list[Path]:
    """Writes `JOB.onnx` for each job, and variants; raises `GraphError` if one is wrong."""
    model = read_model(model_path).model
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    made = {job: (job, make) for job, make in GRAPHS.items()} | VARIANTS
    for name, (job, make) in made.items():
        graph = make(model)
        check(model, job, graph)
        written.append(folder / f"{name}.onnx")
        write_whole(written[-1], graph)
    return written


def check(model: Model, job: str, graph: bytes) -> None:
    """Compares a graph with the model on random inputs; raises `GraphError`."""
    ready = session(graph)
    names = [output.name for output in ready.get_outputs()]
    function = jax.jit(FUNCTIONS[job](model))
    rng = np.random.default_rng(0)
    for trial in range(TRIALS):
        inputs = random_inputs(model, job, rng)
        expected: Mapping[str, Any] = function(*inputs.values())
        for name, got in zip(names, ready.run(names, inputs), strict=True):
            difference = np.abs(np.ravel(got) - np.ravel(np.asarray(expected[name]))).max()
            if not difference <= TOLERANCE:
                raise GraphError(
                    f"{job}.onnx: {name} differs from the model's by {difference:.1e} on random "
                    f"input {trial} of seed 0: correct learning/comparison/graphs.py"
                )


def random_inputs(model: Model, job: str, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Inputs of a job, of which a plan has two descriptions with up to two values each."""
    words, concepts = len(model.language.embedding.weight), len(model.vision.concept.weight)
    tokens = rng.integers(1, words, TOKENS)
    filters = np.zeros((TOKENS, concepts), bool)
    groups = rng.choice(TOKENS, 2, replace=False)
    tokens[groups] = network.GROUP_TOKEN
    for group in groups:
        filters[group, rng.integers(0, concepts, 2)] = True
    count = 1 if job == "crop" else OBJECTS
    side = network.CROP

    def real(*shape: int) -> np.ndarray:
        return rng.random(shape, np.float32)

    values = {
        "tokens": tokens,
        "filters": filters,
        "words": real(TOKENS, 1, network.WORD) - 0.5,
        "splitter_words": real(TOKENS, 1, network.SPLITTER_WORD) - 0.5,
        "embeddings": 2 * real(OBJECTS, network.OBJECT_EMBEDDING),
        "locations": real(OBJECTS, network.LOCATION),
        "action": rng.integers(0, len(model.language.action_decoder.weight), 1),
        "pair": real(1, 2 * network.LOCATION),
        "crops": real(count, 3, side, side),
    }
    return {name: values[name] for name in INPUTS[job]}
