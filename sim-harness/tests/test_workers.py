"""Functions carried out by processes and by a Ray cluster: the same results, told as they come."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from nsrm_harness import domain as domains
from nsrm_harness.episodes.generate import SHARD, SPLITS, generate
from nsrm_harness.errors import EpisodeSettingsError
from nsrm_harness.workers import Processes, RayCluster, WorkersError

SETTINGS = replace(SPLITS["train"], count=2 * SHARD + 1, seed=3, renderer="pybullet")


def test_processes_tell_what_is_finished_by_key() -> None:
    found = dict(Processes(2).each(divmod, [(n, (n, 3)) for n in range(5)]))
    assert found == {n: divmod(n, 3) for n in range(5)}
    with pytest.raises(ZeroDivisionError):
        list(Processes(1).each(divmod, [("bad", (1, 0))]))


def test_a_cluster_of_two_makes_the_same_bytes(tmp_path: Path) -> None:
    domain = domains.load()
    with RayCluster("local", 2) as cluster:
        assert cluster.count == 2
        assert generate(SETTINGS, domain, tmp_path / "cluster.h5", cluster)
        kinds = product(*([value.name for value in each.values] for each in domain.attributes))
        nothing = replace(SETTINGS, exclude=tuple(kinds))
        with pytest.raises(EpisodeSettingsError, match=r"every combination .* is excluded"):
            generate(nothing, domain, tmp_path / "never.h5", cluster)
    assert generate(SETTINGS, domain, tmp_path / "here.h5", Processes(2))
    assert (tmp_path / "cluster.h5").read_bytes() == (tmp_path / "here.h5").read_bytes()


@pytest.mark.parametrize("address", ["127.0.0.1:1", "nowhere"])
def test_a_cluster_that_is_not_there_is_told(address: str) -> None:
    with pytest.raises(WorkersError, match=f"no Ray cluster at '{address}'"):
        RayCluster(address)
