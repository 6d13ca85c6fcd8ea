"""All processes of a robot as a newcomer starts them: `cargo robot`, from the root of the
checkout."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from nsrm_harness.nodes.processes import ProcessGroup

ROOT = Path(__file__).resolve().parents[2]
SHARED_MEMORY = Path("/dev/shm")
LIMITS = """
[limits]
scene_age_ms = 3600000
scene_wait_ms = 3600000
accept_wait_ms = 3600000
move_wait_ms = 3600000
silence_ms = 3600000
"""
"""An hour: nothing here is about time, and the machine may have other work."""


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The path of a configuration with these limits."""
    path = tmp_path_factory.mktemp("limits") / "robot.toml"
    path.write_text(LIMITS)
    return str(path)


def robot(config: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs `cargo robot` to its end."""
    return subprocess.run(
        ["cargo", "robot", "--config", config, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )


def events(done: subprocess.CompletedProcess[str]) -> list[dict[str, Any]]:
    """What it printed, a line for each thing that happened."""
    return [json.loads(line) for line in done.stdout.splitlines()]


def ready(line: str) -> dict[str, Any]:
    """What a world says of itself when it is ready."""
    return json.loads(line)["ready"]


def left_behind() -> set[str]:
    """Shared memory of iceoryx2, but for the segment that it keeps for all nodes."""
    names = (path.name for path in SHARED_MEMORY.iterdir())
    return {name for name in names if "iox2" in name and not name.endswith(".global_mgmt")}


@pytest.mark.parametrize("seed", ["3", "4"])
@pytest.mark.parametrize(
    "options",
    [[], ["--open-loop"], ["--no-arm"], ["--no-arm", "--open-loop"]],
    ids=["closed", "open", "no arm", "open, no arm"],
)
def test_a_sentence_is_carried_out(config: str, seed: str, options: Sequence[str]) -> None:
    before = left_behind()
    done = robot(config, "--seed", seed, "--json", *options)
    assert done.returncode == 0, done.stderr + done.stdout
    happened = events(done)
    kinds = [event["event"] for event in happened]
    steps = len(happened[0]["steps"])
    assert kinds[0] == "planned" and kinds[-1] == "done"
    assert kinds.count("reached") == steps
    assert [event["number"] for event in happened] == list(range(1, len(happened) + 1))
    seen = [event["off_m"] for event in happened if event["event"] == "reached"]
    if "--open-loop" in options:
        assert seen == [None] * steps and kinds.count("planned") == 1
    else:
        assert all(off < 0.01 for off in seen)
    assert left_behind() <= before


def test_a_planner_in_a_control_loop_carries_a_sentence_out_and_prints_its_ticks(
    config: str, tmp_path: Path
) -> None:
    # The example as `cargo test` builds it, of which all that it needs is then built already;
    # without core's, which has the same name.
    for build in (
        ["--release", "--package=nsrm"],
        ["--workspace", "--exclude=nsrm-core", "--example=control_loop"],
    ):
        command = ["cargo", "build", "--quiet", "--locked", *build]
        subprocess.run(command, cwd=ROOT, check=True)
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    nsrm = str(built / "release" / "nsrm")
    # A copy: another build may put core's in its place.
    loop = str(shutil.copy(built / "debug" / "examples" / "control_loop", tmp_path))
    told = ["--robot", f"loop-{os.getpid()}"]
    with ProcessGroup() as processes:
        world = [sys.executable, "-m", "nsrm_harness.cli", "world", "--seed=4", "--no-arm", *told]
        world.append("--json")
        # Until it is told to end.
        length = ["--seconds", "3600", "--limits-s", "3600"]
        sentence = ready(processes.start("world", world, '"ready"'))["sentence"]
        processes.start("perception", [nsrm, "perceive", *told], "perceiving")
        with subprocess.Popen(
            [loop, *told, *length], stdout=subprocess.PIPE, text=True
        ) as planning:
            assert planning.stdout is not None
            next(said for said in planning.stdout if said.startswith("planning"))
            assert processes.run([nsrm, "say", *told, "--config", config, sentence]) == 0
            planning.send_signal(signal.SIGINT)
            printed = planning.stdout.read()
            assert planning.wait() == 0
    assert "planner's loop, microseconds" in printed
    assert "empty loop beside it, microseconds" in printed
    ticks = next(said for said in printed.splitlines() if said.startswith("missed: "))
    of = re.search(r" of (\d+) ticks by work longer than a period", ticks)
    assert of is not None and int(of[1]) > 0, ticks
    # Every tick is in the histogram of its work.
    loops = printed.split("empty loop beside it")[0].splitlines()
    bars = [said.split("≤")[1].split() for said in loops if "work ≤" in said]
    assert sum(int(bar[1]) for bar in bars) == int(of[1])


def test_text_tells_what_happens(config: str) -> None:
    done = robot(config, "--seed", "4")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith('sentence  "')
    assert lines[-1] == "done"
    assert any(": moving object " in line for line in lines)
    assert sum("done, observed" in line for line in lines) == 2


def test_a_ctrl_c_stops_the_arm_and_all_processes(config: str) -> None:
    before = left_behind()
    with subprocess.Popen(
        ["cargo", "robot", "--config", config, "--seed", "4"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as running:
        assert running.stdout is not None and running.stderr is not None
        # Of two blocks the first is on its way.
        next(line for line in running.stdout if ": moving object " in line)
        os.killpg(running.pid, signal.SIGINT)
        rest = running.stdout.read()
        assert running.wait() == 2
        assert running.stderr.read().splitlines()[-1] == "nsrm: cancelled"
    assert "done" not in rest
    assert left_behind() <= before


def test_what_is_refused_ends_with_2_and_moves_nothing(config: str) -> None:
    for sentence, reason in [
        ("put the crimson block on the blue block", '"crimson" is not a word'),
        ("put the red block under the magenta block", '"under" is not a word'),
    ]:
        done = robot(config, "--seed", "4", sentence)
        assert done.returncode == 2, done.stderr
        assert reason in done.stderr
        assert "moving object" not in done.stdout


def test_one_configuration_serves_all_processes(tmp_path_factory: pytest.TempPathFactory) -> None:
    """As on one of several hosts, where all are on the same."""
    # Short: iceoryx2 makes sockets in it.
    tmp_path = tmp_path_factory.mktemp("r")
    subprocess.run(
        ["cargo", "build", "--quiet", "--release", "--package=nsrm"], cwd=ROOT, check=True
    )
    nsrm = str(Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "nsrm")
    prefix = f"nsrm-test-{os.getpid()}_"
    told = ["--config", str(tmp_path / "robot.toml")]
    (tmp_path / "robot.toml").write_text(
        'robot = "left"\nhosts = "several"\ntransport = "broadcast"\n'
        f'[shared_memory]\nroot = "{tmp_path / "m"}"\nprefix = "{prefix}"\n{LIMITS}'
    )
    with ProcessGroup() as processes:
        world = [sys.executable, "-m", "nsrm_harness.cli", "world", "--seed", "4", *told]
        stage = ready(processes.start("world", [*world, "--json"], '"ready"'))
        assert (stage["robot"], stage["seed"]) == ("left", 4)
        processes.start("perception", [nsrm, "perceive", *told], "perceiving")
        processes.start("planner", [nsrm, "serve", *told], "planning")
        assert processes.run([nsrm, "say", *told, stage["sentence"]]) == 0
    left = [path.name for path in SHARED_MEMORY.iterdir() if path.name.startswith(prefix)]
    assert [name for name in left if not name.endswith(".global_mgmt")] == []
    for name in left:
        (SHARED_MEMORY / name).unlink()
