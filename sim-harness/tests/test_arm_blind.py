"""The arm knows the world by pictures alone: its code can't reach the truth."""

from __future__ import annotations

from another_process import TESTS, elsewhere

TRUTH = (
    "pybullet",
    "nsrm_harness.world.bullet",
    "nsrm_harness.world.world",
    "nsrm_harness.world.arm_world",
    "nsrm_harness.world.moving_arm",
    "nsrm_harness.judge",
    "nsrm_harness.episodes",
)
"""A module of one of these names, or in one of these packages."""

IMPORTING = """
import importlib, pkgutil, sys
import nsrm_harness.arm as arm
for module in pkgutil.walk_packages(arm.__path__, "nsrm_harness.arm."):
    importlib.import_module(module.name)
print(*sorted(sys.modules), sep="\\n")
"""


def loaded_with(code: str) -> set[str]:
    return set(elsewhere(code).split())


def truths(modules: set[str]) -> set[str]:
    return {
        module
        for module in modules
        if any(module == name or module.startswith(f"{name}.") for name in TRUTH)
    }


def test_no_module_of_the_arm_loads_what_knows_the_truth() -> None:
    modules = loaded_with(IMPORTING)
    written = {path.stem for path in (TESTS.parent / "nsrm_harness" / "arm").glob("*.py")}
    assert {f"nsrm_harness.arm.{name}" for name in written - {"__init__"}} <= modules
    assert truths(modules) == set()


def test_the_truth_would_be_noticed() -> None:
    code = (
        "import sys, nsrm_harness.world.arm_world, nsrm_harness.judge, nsrm_harness.episodes.file"
    )
    found = truths(loaded_with(f"{code}\nprint(*sys.modules, sep='\\n')"))
    assert set(TRUTH) <= found
