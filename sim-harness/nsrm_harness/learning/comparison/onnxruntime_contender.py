"""ONNX Runtime as Python programs call it: one thread, all optimisations."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from nsrm_harness.learning.comparison.protocol import Work, inputs_of, serve

# Installed for `cargo compare` alone.
onnxruntime: Any = import_module("onnxruntime")


def session(graph: Path | bytes) -> Any:
    """A session on one thread with all optimisations."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_ALL
    source = str(graph) if isinstance(graph, Path) else graph
    return onnxruntime.InferenceSession(source, options, providers=["CPUExecutionProvider"])


def prepare(folder: Path, job: str) -> Work:
    """A job as one graph."""
    ready = session(folder / f"{job}.onnx")
    feeds = inputs_of(folder, job)
    names = [output.name for output in ready.get_outputs()]
    run = ready.run
    return Work(
        run=lambda: run(names, feeds),
        outputs=lambda: dict(zip(names, run(names, feeds), strict=True)),
    )


if __name__ == "__main__":
    serve(f"ONNX Runtime {onnxruntime.__version__}", prepare)
