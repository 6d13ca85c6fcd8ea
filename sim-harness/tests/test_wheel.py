"""The wheel of this package works outside a checkout."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from zipfile import ZipFile

import pytest

HARNESS = Path(__file__).resolve().parent.parent
PACKAGE = "nsrm_harness"


def pip(*arguments: str | Path) -> None:
    """Without a network: nothing is fetched, and the build takes what is installed."""
    subprocess.run(
        [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", *arguments],
        check=True,
    )


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from a copy: a build leaves folders beside its sources."""
    source = tmp_path_factory.mktemp("source")
    shutil.copy(HARNESS / "pyproject.toml", source)
    shutil.copytree(
        HARNESS / PACKAGE, source / PACKAGE, ignore=shutil.ignore_patterns("__pycache__")
    )
    wheels = tmp_path_factory.mktemp("wheels")
    options = ("--no-index", "--no-deps", "--no-build-isolation", "--no-cache-dir")
    pip("wheel", *options, "--wheel-dir", wheels, source)
    (built,) = wheels.iterdir()
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the packages."""
    folder = tmp_path_factory.mktemp("installed")
    pip("install", "--no-index", "--no-deps", "--target", folder, wheel)
    return folder


def run(installed: Path, folder: Path, arguments: Sequence[str]) -> subprocess.CompletedProcess:
    """Python in a folder, with the installed package before any other."""
    environment = os.environ | {"PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_wheel_has_all_files_of_the_package(wheel: Path) -> None:
    own = {
        f"{PACKAGE}/{path.relative_to(HARNESS / PACKAGE).as_posix()}"
        for path in (HARNESS / PACKAGE).rglob("*")
        if path.is_file() and path.suffix != ".pyc"
    }
    assert {f"{PACKAGE}/domain/tabletop.toml", f"{PACKAGE}/learning/quick.toml"} <= own
    with ZipFile(wheel) as file:
        names = {name for name in file.namelist() if name.startswith(f"{PACKAGE}/")}
    assert names == own


def test_an_installed_package_has_its_domain_and_makes_episodes(
    installed: Path, tmp_path: Path
) -> None:
    found = run(installed, tmp_path, ["-c", "import nsrm_harness as n; print(n.__file__)"])
    assert Path(found.stdout.strip()).is_relative_to(installed), found.stderr
    command = "-m nsrm_harness.cli episodes --split test --count 1 --jobs 1 --out one.h5"
    made = run(installed, tmp_path, command.split())
    assert made.returncode == 0, made.stderr
    assert (tmp_path / "one.h5").stat().st_size > 10_000


@pytest.mark.slow
def test_an_installed_package_has_the_miniature_trainings_configuration(
    installed: Path, tmp_path: Path
) -> None:
    """It is read before the data, of which there are none."""
    command = "-m nsrm_harness.cli train --quick --data none"
    told = run(installed, tmp_path, command.split())
    assert told.returncode == 2
    assert "none/train.h5" in told.stderr and "quick.toml" not in told.stderr
