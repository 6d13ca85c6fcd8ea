"""Commands that use only the demo's packages work without the others."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = ROOT / "xtask" / "src" / "environment.rs"
LOCK = ROOT / "sim-harness" / "requirements" / "demo.txt"
WITHOUT = """
import sys
from importlib import import_module


class Missing:
    def find_spec(self, name, path=None, target=None):
        if name in {missing!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}} in the demo's requirements")


sys.meta_path.insert(0, Missing())
import_module("nsrm_harness.cli.commands.{command}")
"""


def normal(distribution: str) -> str:
    return re.sub(r"[-_.]+", "-", distribution).lower()


def light_commands() -> list[str]:
    listed = re.search(
        r"LIGHT_COMMANDS: \[&str; \d+\] = \[(.*?)\]", ENVIRONMENT.read_text(), re.DOTALL
    )
    assert listed is not None
    return re.findall(r'"(\w+)"', listed[1])


def missing_modules() -> set[str]:
    """Installed for the checks, but not for the demo."""
    locked = set(map(normal, re.findall(r"^([\w.-]+)==", LOCK.read_text(), re.MULTILINE)))
    ours = {"nsrm", "pip", "setuptools"}
    return {
        module
        for module, distributions in packages_distributions().items()
        if not (locked | ours) & set(map(normal, distributions))
    }


def load(command: str) -> subprocess.CompletedProcess[str]:
    code = WITHOUT.format(missing=missing_modules(), command=command)
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False
    )


@pytest.mark.slow
@pytest.mark.parametrize("command", light_commands())
def test_light_commands_need_the_demos_packages_alone(command: str) -> None:
    loaded = load(command)
    assert loaded.returncode == 0, loaded.stderr


def test_commands_that_draw_curves_need_more() -> None:
    """Or the test above would see nothing."""
    assert "demo's requirements" in load("soak").stderr
