"""Builds ONNX graphs node by node."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

# Installed for `cargo compare` alone.
onnx: Any = import_module("onnx")

OPERATOR_SET = 17
"""Version of the operators, which all runtimes know."""
FILE_FORMAT = 9
"""Version of the file's format that belongs to it."""


class Graph:
    """A graph in the making. Every method adds a node and returns the name of its result."""

    def __init__(self, name: str):
        self._name = name
        self._nodes: list[Any] = []
        self._constants: list[Any] = []
        self._inputs: list[Any] = []

    def input(self, name: str, dtype: type, shape: Sequence[int]) -> str:
        """Declares an input."""
        self._inputs.append(self._value(name, dtype, shape))
        return name

    def constant(self, array: np.ndarray) -> str:
        """Adds a constant; float64 is stored as float32."""
        if array.dtype == np.float64:
            array = array.astype(np.float32)
        name = f"constant_{len(self._constants)}"
        array = np.ascontiguousarray(array)
        self._constants.append(onnx.numpy_helper.from_array(array, name))
        return name

    def node(self, operator: str, *inputs: str, outputs: int = 1, **attributes: Any) -> list[str]:
        """Adds a node with several results."""
        name = f"{operator.lower()}_{len(self._nodes)}"
        results = [f"{name}_{number}" for number in range(outputs)]
        made = onnx.helper.make_node(operator, list(inputs), results, name=name, **attributes)
        self._nodes.append(made)
        return results

    def add(self, operator: str, *inputs: str, **attributes: Any) -> str:
        """Adds a node with one result."""
        return self.node(operator, *inputs, **attributes)[0]

    def dense(self, rows: str, weight: np.ndarray, bias: np.ndarray | str) -> str:
        """`rows @ weight.T + bias`: `[N, I]`, `[O, I]`, `[O]` -> `[N, O]`.

        * `bias`: or the name of a result `[N, O]`
        """
        added = bias if isinstance(bias, str) else self.constant(bias)
        return self.add("Gemm", rows, self.constant(weight), added, transB=1)

    def reshape(self, value: str, *shape: int) -> str:
        """The same values in another shape."""
        return self.add("Reshape", value, self.constant(np.array(shape, np.int64)))

    def bytes(self, outputs: Mapping[str, tuple[str, type, Sequence[int]]]) -> bytes:
        """The finished file; `outputs`: for each name the result, its type and its shape."""
        for name, (result, _, _) in outputs.items():
            self._nodes.append(onnx.helper.make_node("Identity", [result], [name], name=name))
        declared = [self._value(name, of, shape) for name, (_, of, shape) in outputs.items()]
        graph = onnx.helper.make_graph(
            self._nodes, self._name, self._inputs, declared, self._constants
        )
        model = onnx.helper.make_model(
            graph,
            opset_imports=[onnx.helper.make_opsetid("", OPERATOR_SET)],
            ir_version=FILE_FORMAT,
            producer_name="nsrm_harness",
        )
        onnx.checker.check_model(model, full_check=True)
        return model.SerializeToString(deterministic=True)

    @staticmethod
    def _value(name: str, dtype: type, shape: Sequence[int]) -> Any:
        element = onnx.helper.np_dtype_to_tensor_dtype(np.dtype(dtype))
        return onnx.helper.make_tensor_value_info(name, element, list(shape))
