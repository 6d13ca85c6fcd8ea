"""The side of a contender in Python; `tests/compare/src/protocol.rs` documents the protocol."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file

from nsrm_harness.common.errors import HarnessError

INPUTS: Mapping[str, Sequence[str]] = {
    "plan": ("tokens", "filters", "embeddings", "locations"),
    "encoder": ("words",),
    "splitter": ("splitter_words",),
    "simulator": ("action", "pair"),
    "crop": ("crops",),
    "crops": ("crops",),
}
"""The inputs of each job, in the order of its graph's."""

Outputs = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Work:
    """A job that is ready.

    * `run`: does it once; this is timed
    * `outputs`: what it gives, by name
    """

    run: Callable[[], object]
    outputs: Callable[[], Outputs]


class ProtocolError(HarnessError):
    """A line that no driver writes."""


def inputs_of(folder: Path, job: str) -> dict[str, np.ndarray]:
    """The inputs of a job; one crop is the first of six."""
    everything = load_file(folder / "inputs.safetensors")
    found = {name: everything[name] for name in INPUTS[job]}
    if job == "crop":
        found["crops"] = found["crops"][:1]
    return found


def serve(version: str, prepare: Callable[[Path, str], Work]) -> None:
    """Answers the driver until its lines end.

    * `prepare`: gets a job ready, with the files of a folder
    """
    folder = Path(sys.argv[1])
    prepared: dict[str, Work] = {}
    _answer(f"ready {version}")
    for line in sys.stdin:
        match line.split():
            case ["outputs", job] if job in INPUTS:
                if job not in prepared:
                    prepared[job] = prepare(folder, job)
                for name, values in prepared[job].outputs().items():
                    numbers = " ".join(repr(float(value)) for value in np.ravel(values))
                    _answer(f"output {name} {numbers}")
                _answer("end")
            case ["time", job, runs] if job in prepared:
                times = _timed(prepared[job].run, int(runs))
                _answer("times " + " ".join(map(str, times)))
            case _:
                raise ProtocolError(f"unknown request {line!r}")


def _timed(run: Callable[[], object], runs: int) -> list[int]:
    clock, times = time.perf_counter_ns, []
    for _ in range(runs):
        start = clock()
        run()
        times.append(clock() - start)
    return times


def _answer(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()
