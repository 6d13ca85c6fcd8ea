"""Functions run by processes and by a Ray cluster: the same results, in order of completion."""

from __future__ import annotations

import subprocess
import sys
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.workers import LocalProcesses, RayCluster, WorkersError

pytestmark = pytest.mark.slow


def episodes(*options: str | Path) -> subprocess.CompletedProcess[str]:
    """``harness episodes`` in a process of its own: a cluster is forked off the one that starts it,
    and the tests' has JAX's threads."""
    command = [sys.executable, "-m", "nsrm_harness.cli", "episodes", "--split", "train"]
    command += ["--count", "11", "--seed", "3", "--renderer", "pybullet", "--jobs", "2"]
    return subprocess.run(
        [*command, *map(str, options)], capture_output=True, text=True, timeout=900, check=False
    )


def test_processes_tell_what_is_finished_by_key() -> None:
    found = dict(LocalProcesses(2).each(divmod, [(n, (n, 3)) for n in range(5)]))
    assert found == {n: divmod(n, 3) for n in range(5)}
    with pytest.raises(ZeroDivisionError):
        list(LocalProcesses(1).each(divmod, [("bad", (1, 0))]))


def test_a_cluster_of_two_makes_the_same_bytes(tmp_path: Path) -> None:
    here, cluster = tmp_path / "here.h5", tmp_path / "cluster.h5"
    for path, options in ((here, ()), (cluster, ("--ray", "local"))):
        ran = episodes("--out", path, *options)
        assert ran.returncode == 0, ran.stderr
    assert here.read_bytes() == cluster.read_bytes()


def test_an_error_on_the_cluster_is_told_as_if_it_were_here(tmp_path: Path) -> None:
    values = ([value.name for value in each.values] for each in domains.load().attributes)
    excluded = [option for kind in product(*values) for option in ("--exclude", ",".join(kind))]
    ran = episodes("--out", tmp_path / "never.h5", "--ray", "local", *excluded)
    assert ran.returncode == 2
    problem = "almost every combination of attribute values is excluded: exclude fewer"
    assert ran.stderr.splitlines()[-1] == f"harness: {problem}"


def test_the_whole_package_is_sent_to_the_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    told: dict[str, Any] = {}
    ray = SimpleNamespace(init=lambda **options: told.update(options), cluster_resources=dict)
    monkeypatch.setitem(sys.modules, "ray", ray)
    RayCluster("auto")
    (sent,) = told["runtime_env"]["py_modules"]
    assert Path(sent).name == "nsrm_harness"
    assert {"common", "data", "domain"} <= {entry.name for entry in Path(sent).iterdir()}


@pytest.mark.parametrize("address", ["127.0.0.1:1", "nowhere"])
def test_a_cluster_that_is_not_there_is_told(address: str) -> None:
    with pytest.raises(WorkersError, match=f"no Ray cluster at '{address}'"):
        RayCluster(address)
