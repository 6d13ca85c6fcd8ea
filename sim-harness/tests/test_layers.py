"""The layers of the harness: each package imports only itself and lower ones."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "nsrm_harness"

LAYERS = (
    "common",
    "geometry",
    "domain",
    "perception",
    "manipulation",
    "simulation",
    "data",
    "visualization",
    "nodes",
    "demo",
    "evaluation",
    "learning",
    "paper",
    "cli",
)
"""From the lowest to the highest."""

ALLOWED = {
    # Neither sees the simulator, whatever stands between them.
    "perception": {"common", "geometry", "domain"},
    "manipulation": {"common", "geometry", "domain", "perception"},
}
"""For packages that import fewer than all those below them."""


def imports() -> Iterator[tuple[str, str, str]]:
    """Each import of the harness: its file, the package that it is in, and the one it imports."""
    for path in PACKAGE.rglob("*.py"):
        file = path.relative_to(PACKAGE)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names: list[str] = []
            if isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module]
                if node.module == PACKAGE.name:
                    names = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            for name in names:
                if name.startswith(f"{PACKAGE.name}."):
                    yield str(file), file.parts[0], name.split(".")[1]


def test_every_package_has_a_layer() -> None:
    packages = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert packages == set(LAYERS)
    assert {path.name for path in PACKAGE.glob("*.py")} == {"__init__.py"}


def test_no_package_imports_one_above_it() -> None:
    upwards = []
    for file, package, imported in imports():
        if package not in LAYERS:
            continue
        below = LAYERS[: LAYERS.index(package) + 1]
        allowed = ALLOWED.get(package, set(below)) | {package}
        if imported not in allowed:
            upwards.append(f"{file} imports {imported}")
    assert upwards == []


def test_no_two_classes_have_one_name() -> None:
    names = Counter(
        node.name
        for path in PACKAGE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in names.items() if count > 1] == []
