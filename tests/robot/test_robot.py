"""All processes of a robot as a newcomer starts them: `cargo robot`, from the root of the
checkout."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
SHARED_MEMORY = Path("/dev/shm")


def robot(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs `cargo robot` to its end."""
    return subprocess.run(
        ["cargo", "robot", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


def events(done: subprocess.CompletedProcess[str]) -> list[dict[str, Any]]:
    """What it printed, a line for each thing that happened."""
    return [json.loads(line) for line in done.stdout.splitlines()]


def left_behind() -> set[str]:
    """Shared memory of iceoryx2, but for the segment that it keeps for all nodes."""
    names = (path.name for path in SHARED_MEMORY.iterdir())
    return {name for name in names if "iox2" in name and not name.endswith(".global_mgmt")}


@pytest.mark.parametrize("seed", ["3", "4"])
@pytest.mark.parametrize("options", [[], ["--open-loop"]], ids=["closed", "open"])
def test_a_sentence_is_carried_out(seed: str, options: Sequence[str]) -> None:
    before = left_behind()
    done = robot("--seed", seed, "--json", *options)
    assert done.returncode == 0, done.stderr + done.stdout
    happened = events(done)
    kinds = [event["event"] for event in happened]
    steps = len(happened[0]["steps"])
    assert kinds[0] == "planned" and kinds[-1] == "done"
    assert kinds.count("reached") == steps
    assert [event["number"] for event in happened] == list(range(1, len(happened) + 1))
    seen = [event["off_m"] for event in happened if event["event"] == "reached"]
    if options:
        assert seen == [None] * steps and kinds.count("planned") == 1
    else:
        assert all(off < 0.01 for off in seen)
    assert left_behind() <= before


def test_text_tells_what_happens() -> None:
    done = robot("--seed", "4")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith('sentence  "')
    assert lines[-1] == "done"
    assert any("is on its way to" in line for line in lines)
    assert sum("done, seen" in line for line in lines) == 2


def test_what_is_refused_ends_with_2_and_moves_nothing() -> None:
    for sentence, reason in [
        ("put the crimson block on the blue block", '"crimson" is not a word'),
        ("put the red block under the magenta block", '"under" is not a word'),
    ]:
        done = robot("--seed", "4", sentence)
        assert done.returncode == 2, done.stderr
        assert reason in done.stderr
        assert "on its way" not in done.stdout
