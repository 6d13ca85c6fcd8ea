"""Tracking across images, and a controller that executes each command once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from nsrm_harness import domain as domains
from nsrm_harness.data.tabletop import tabletop
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.nodes import ports
from nsrm_harness.nodes.config import RobotConfigError, read_config
from nsrm_harness.nodes.controller import Answer, Controller, fault, stops_first
from nsrm_harness.nodes.leftovers import SEGMENTS, remove_segments
from nsrm_harness.nodes.messages import Heartbeat, Kind, Outcome, Role, State, SubGoal
from nsrm_harness.nodes.ports import (
    BEAT_NS,
    LINE_NS,
    FeedbackOut,
    FramesOut,
    Heartbeats,
    PortError,
    RobotServices,
)
from nsrm_harness.nodes.simulated_robot import FRAME_S, SimulatedRobot
from nsrm_harness.nodes.teleport_mover import TeleportMover
from nsrm_harness.perception.cuboids import faces
from nsrm_harness.perception.detector import detect
from nsrm_harness.perception.relief import relief
from nsrm_harness.perception.tracking import Tracker
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.simulation.world import World

SEED = 4
NOW_NS = 10**15


@pytest.fixture
def world() -> Iterator[World]:
    scene = tabletop(domains.load(), SEED).arrangement
    with World() as opened:
        opened.spawn(scene.blocks, scene.poses)
        opened.settle()
        yield opened


def look(tracker: Tracker, renderer: Renderer, world: World) -> dict[int, int]:
    """The tracker's number of each block, by whose centre is nearest to it."""
    camera = default_camera()
    frame = renderer.render(world, camera, Light())
    found = detect(frame.rgb, frame.depth, camera)
    heights = relief(frame.rgb, frame.depth, camera)
    seen = faces(found, heights, camera)
    numbers = tracker.update(frame.rgb, found, seen, heights, camera)
    named: dict[int, int] = {}
    for number in numbers:
        position = tracker.position(number)
        assert position is not None
        distance = {key: pose.distance_m(_at(position)) for key, pose in world.poses().items()}
        named[min(distance, key=lambda key: distance[key])] = number
    return named


def _at(position: NDArray[np.float64]) -> Pose:
    x, y, z = (float(value) for value in position)
    return Pose((x, y, z), (0.0, 0.0, 0.0, 1.0))


def test_objects_keep_their_numbers_when_they_are_moved(renderer: Renderer, world: World) -> None:
    tracker = Tracker()
    first = look(tracker, renderer, world)
    assert sorted(first) == [1, 2, 3, 4]
    assert look(tracker, renderer, world) == first
    # Each in turn to the other side of the table, and then back onto another.
    for block_id, y in [(1, -0.2), (2, -0.1), (3, 0.0), (4, 0.1)]:
        world.place(block_id, Pose((0.62, y, 0.03), (0.0, 0.0, 0.0, 1.0)))
        world.settle()
        assert look(tracker, renderer, world) == first
    x, y, z = world.pose(2).position
    world.place(1, Pose((x, y, z + 0.05), (0.0, 0.0, 0.0, 1.0)))
    world.settle()
    assert look(tracker, renderer, world) == first


def test_a_new_object_gets_a_new_number(renderer: Renderer, world: World) -> None:
    tracker = Tracker()
    assert tracker.position(1) is None
    named = look(tracker, renderer, world)
    assert sorted(named.values()) == [1, 2, 3, 4]
    world.reset()
    other = tabletop(domains.load(), SEED + 1).arrangement
    world.spawn(other.blocks, other.poses)
    world.settle()
    numbers = look(tracker, renderer, world).values()
    assert len(set(numbers)) == len(other.blocks)
    assert max(numbers) > 4


class Ear:
    """Remembers what the controller said and passed over."""

    def __init__(self) -> None:
        self.said: list[tuple[int, int, Outcome]] = []
        self.rejected: list[str] = []

    def reject(self, service: str, why: str) -> None:
        assert service == "sub_goal"
        self.rejected.append(why)

    def __call__(self, plan: int, command: int, answer: Answer) -> None:
        self.said.append((plan, command, answer.outcome))

    def outcomes(self) -> list[Outcome]:
        said = [outcome for *_, outcome in self.said]
        self.said.clear()
        return said


def move(plan: int, number: int, object_id: int, position: tuple[float, float, float]) -> SubGoal:
    command = SubGoal(plan=plan, command=number, kind=Kind.MOVE, object_id=object_id)
    command.steps, command.reference_id, command.until_ns = 1, 99, NOW_NS
    command.position[:] = position
    command.orientation[:] = (0.0, 0.0, 0.0, 1.0)
    return command


def test_a_command_is_carried_out_once_however_often_it_comes(world: World) -> None:
    ear = Ear()
    seen = {7: world.pose(1).position}
    controller = Controller(TeleportMover(world, seen.get), ear, ear.reject, lambda: NOW_NS)
    there = move(5, 1, 7, (0.62, 0.0, 0.021))
    controller.obey(there)
    assert ear.outcomes() == [Outcome.ACCEPTED, Outcome.REACHED]
    pose = world.pose(1)
    world.place(1, Pose((0.62, 0.2, 0.03), (0.0, 0.0, 0.0, 1.0)))
    world.settle()
    moved = world.pose(1)
    assert moved.distance_m(pose) > 0.1
    controller.obey(there)
    controller.obey(SubGoal(plan=5, command=1, kind=Kind.STOP))
    assert ear.outcomes() == [Outcome.REACHED, Outcome.REACHED]
    assert world.pose(1) == moved
    # What is older than the last is not done any more.
    controller.obey(move(4, 9, 7, (0.62, 0.0, 0.021)))
    assert ear.outcomes() == [Outcome.IMPOSSIBLE]
    assert world.pose(1) == moved
    # A stop that comes before what it stops.
    controller.obey(SubGoal(plan=6, command=2, kind=Kind.STOP))
    controller.obey(move(6, 2, 7, (0.62, 0.0, 0.021)))
    assert ear.outcomes() == [Outcome.STOPPED, Outcome.STOPPED]
    assert world.pose(1) == moved


def test_what_can_not_be_grasped_or_does_not_stay_is_said(world: World) -> None:
    ear = Ear()
    seen = {7: world.pose(1).position, 8: (0.5, -0.6, 0.0)}
    controller = Controller(TeleportMover(world, seen.get), ear, ear.reject, lambda: NOW_NS)
    for number, (object_id, position, outcome) in enumerate(
        [
            (9, (0.62, 0.0, 0.021), Outcome.IMPOSSIBLE),
            (8, (0.62, 0.0, 0.021), Outcome.NOT_GRASPED),
            (7, (0.62, 0.0, 0.2), Outcome.MISPLACED),
        ],
        start=1,
    ):
        controller.obey(move(1, number, object_id, position))
        assert ear.outcomes() == [Outcome.ACCEPTED, outcome]


@pytest.mark.parametrize(
    ("field", "value", "why"),
    [
        ("command", 0, "command 0"),
        ("kind", 3, "unknown kind 3"),
        ("step", 1, "step 1 of 1"),
        ("steps", 9, "step 0 of 9"),
        ("object_id", 0, "object 0"),
        ("reference_id", 0, "object 0"),
        ("reference_id", 7, "is its own reference"),
        ("confidence", float("nan"), "not finite"),
        ("position", (0.5, float("inf"), 0.0), "not finite"),
        ("orientation", (0.0, 0.0, 0.0, 2.0), "length 1"),
        ("location", (0.0, 0.0, 0.0, 0.0, float("nan")), "not finite"),
        ("confidence", 1.5, "confidence of 1.5"),
    ],
)
def test_each_fault_of_a_command_is_named(field: str, value: object, why: str) -> None:
    command = move(5, 1, 7, (0.62, 0.0, 0.021))
    assert fault(command) is None
    setattr(command, field, value)
    assert why in (fault(command) or "")


def test_who_sends_nonsense_moves_nothing_and_is_counted(world: World) -> None:
    ear = Ear()
    seen = {7: world.pose(1).position}
    controller = Controller(TeleportMover(world, seen.get), ear, ear.reject, lambda: NOW_NS)
    before = world.poses()
    size = len(bytes(SubGoal()))
    rng = np.random.default_rng(7)
    for content in [b"\0" * size, b"\xff" * size, *(rng.bytes(size) for _ in range(3000))]:
        controller.obey(SubGoal.from_buffer_copy(content))
    for _ in range(1000):
        # Sound but for what is put into its middle.
        command = move(int(rng.integers(1 << 63)), 1, 7, (0.62, 0.0, 0.021))
        command.position[:] = np.frombuffer(rng.bytes(12), np.float32).tolist()
        command.orientation[:] = (0.5, 0.0, 0.0, 0.0)
        controller.obey(command)
    assert len(ear.rejected) == 4002
    assert set(ear.outcomes()) == {Outcome.IMPOSSIBLE}
    assert world.poses() == before
    # Whatever numbers those had.
    controller.obey(move(1, 1, 7, (0.62, 0.0, 0.021)))
    assert ear.outcomes() == [Outcome.ACCEPTED, Outcome.REACHED]


def test_what_waited_too_long_or_was_given_up_moves_nothing(world: World) -> None:
    ear = Ear()
    seen = {7: world.pose(1).position}
    controller = Controller(TeleportMover(world, seen.get), ear, ear.reject, lambda: NOW_NS)
    before = world.poses()
    late = move(5, 1, 7, (0.62, 0.0, 0.021))
    late.until_ns = NOW_NS - 3_000_000
    controller.obey(late)
    assert ear.outcomes() == [Outcome.TOO_LATE]
    assert ear.rejected == ["3 ms after its time"]
    # In time, but its stop is there already when it is read.
    given_up = move(6, 1, 7, (0.62, 0.0, 0.021))
    for command in stops_first([given_up, SubGoal(plan=6, command=1, kind=Kind.STOP)]):
        controller.obey(command)
    assert ear.outcomes() == [Outcome.STOPPED, Outcome.STOPPED]
    assert world.poses() == before
    controller.obey(move(7, 1, 7, (0.62, 0.0, 0.021)))
    assert ear.outcomes() == [Outcome.ACCEPTED, Outcome.REACHED]


def test_a_configuration_says_what_is_wrong_with_it(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    for text, words in [
        ("robot = ", "Invalid value"),
        (
            'arms = 2\nrobot = "left"',
            "arms: unknown key; expected some of: hosts, limits, model, ",
        ),
        ("robot = 5", "robot: should be a valid string, got 5"),
        ('hosts = "two"', "hosts: expected 'one' or 'several', got 'two'"),
        ("shared_memory = 3", "shared_memory: expected a table, got 3"),
        (
            "[shared_memory]\nfolder = 'x'",
            "shared_memory.folder: unknown key; expected some of: prefix, root",
        ),
        (
            "[shared_memory]\nprefix = 'a/b'",
            "shared_memory.prefix: too long, or not a valid file name: got 'a/b'",
        ),
        ("[shared_memory]\nroot = 3", "shared_memory.root: should be a valid string, got 3"),
        ("[shared_memory]\nroot = 'here'", "shared_memory.root: an absolute path is needed"),
    ]:
        file.write_text(text)
        with pytest.raises(RobotConfigError) as refused:
            read_config(file)
        assert str(file) in str(refused.value) and words in str(refused.value)
    with pytest.raises(RobotConfigError, match=r"none\.toml"):
        read_config(tmp_path / "none.toml")


def test_a_configuration_is_that_of_nsrm(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text(
        'robot = "left"\nmodel = "m"\ntransport = "broadcast"\nhosts = "several"\n'
        "[limits]\nretries = 1\n[shared_memory]\nroot = '/tmp/here'\nprefix = 'mine_'\n"
    )
    config = read_config(file)
    assert (config.robot, config.several_hosts) == ("left", True)
    places = config.shared_memory.global_cfg
    assert places.root_path.to_string() == "/tmp/here"
    assert places.prefix.to_string() == "mine_"
    assert read_config(file, "right").robot == "right"
    assert read_config(None) == read_config(None, "robot")
    assert not read_config(None).several_hosts


@pytest.fixture
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A configuration with a corner of shared memory of its own, with nothing left in the end."""
    # Short: iceoryx2 makes sockets in it.
    folder, prefix = tmp_path_factory.mktemp("r"), f"nsrm-test-{os.getpid()}_"
    file = folder / "robot.toml"
    file.write_text(f'[shared_memory]\nroot = "{folder}/m"\nprefix = "{prefix}"\n')
    yield file
    left = [path for path in SEGMENTS.iterdir() if path.name.startswith(prefix)]
    for path in left:
        path.unlink()
    assert [path for path in left if not path.name.endswith(".global_mgmt")] == []


def segment(place: Path, name: str, age_s: float) -> Path:
    """A segment whose maker was killed before it gave it a size."""
    config = read_config(place).shared_memory
    path = SEGMENTS / f"{config.global_cfg.prefix.to_string()}{name}.connection"
    path.touch()
    then = time.time() - age_s
    os.utime(path, (then, then))
    return path


def test_a_segment_that_was_given_up_keeps_nobody_waiting(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = time.time()

    def sleep(seconds: float) -> None:
        nonlocal now_s
        now_s += seconds

    # However slow the machine, no more time goes by than is slept.
    monkeypatch.setattr(time, "time", lambda: now_s)
    monkeypatch.setattr(time, "monotonic", lambda: now_s)
    monkeypatch.setattr(time, "sleep", sleep)
    old, new = segment(place, "1_2", 60.0), segment(place, "3_4", 0.5)
    began_s = now_s
    # Which waits until the second one has been given up, too.
    robot = RobotServices(read_config(place), "controller")
    assert not old.exists() and not new.exists()
    assert 0.5 < now_s - began_s < 0.6
    young = segment(place, "5_6", 0.5)
    assert not robot.cleanup_dead_nodes() and young.exists()
    sleep(0.6)
    assert robot.cleanup_dead_nodes() and not young.exists()


@pytest.fixture
def begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A segment of this user's, given up, among segments kept elsewhere."""
    monkeypatch.setattr("nsrm_harness.nodes.leftovers.SEGMENTS", tmp_path)
    path = tmp_path / "mine_1_2.connection"
    path.touch()
    os.utime(path, (0.0, 0.0))
    return path


def test_a_segment_of_other_users_keeps_nobody_waiting(
    begun: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: other)
    nowhere = begun.parent / "none"
    assert not remove_segments("mine_", nowhere) and begun.exists()
    os.utime(begun)
    assert not remove_segments("mine_", nowhere) and begun.exists()
    # Whose folder it is may have begun it.
    assert remove_segments("mine_", begun.parent)
    os.utime(begun, (0.0, 0.0))
    assert not remove_segments("mine_", begun.parent) and not begun.exists()


class _Turns:
    """Is set after so many turns; keeps how long was waited behind each."""

    def __init__(self, turns: int) -> None:
        self.turns, self.rests_s = turns, list[float]()

    def is_set(self) -> bool:
        return len(self.rests_s) == self.turns

    def wait(self, rest_s: float) -> None:
        self.rests_s.append(rest_s)


def test_a_clock_that_is_set_back_does_not_hold_up_the_camera(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # An hour each time that it is asked for the time.
    times = iter(range(10**18, 0, -3600 * 10**9))
    monkeypatch.setattr(ports, "_clock", lambda: next(times))
    stage = SimulatedRobot.__new__(SimulatedRobot)
    monkeypatch.setattr(stage, "turn", lambda: None)
    stop = _Turns(2)
    stage.run(cast(threading.Event, stop))
    assert max(stop.rests_s) <= FRAME_S


@pytest.mark.parametrize(
    ("error", "being_made"),
    [(PermissionError, True), (OSError, True), (FileNotFoundError, False)],
)
def test_a_segment_that_stays_may_be_being_made(
    begun: Path, monkeypatch: pytest.MonkeyPatch, error: type[OSError], being_made: bool
) -> None:
    def refuse(_: Path) -> None:
        raise error

    monkeypatch.setattr(Path, "unlink", refuse)
    assert remove_segments("mine_", begun.parent) == being_made


def test_too_little_shared_memory_is_refused(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = list(os.statvfs(SEGMENTS))

    def leave(size: int, limit: int = 100) -> None:
        # Sizes of blocks, how many there are, how many are free, for users as well.
        found[0:5] = [4096, 4096, limit, size // 4096, size // 4096]
        monkeypatch.setattr(os, "statvfs", lambda _: os.statvfs_result(found))

    leave(1 << 19)
    with pytest.raises(PortError, match=r"`node` needs 1.0 MB of shared memory, but 0.5 are left"):
        RobotServices(read_config(place), "camera")
    # One without blocks has no limit.
    leave(0, limit=0)
    robot = RobotServices(read_config(place), "camera")
    leave(3 << 20)
    with pytest.raises(PortError, match=r"`camera` needs 5.0 MB .* but 3.1 are left in /dev/shm"):
        FramesOut(robot, 500, 285)
    FramesOut(robot, 100, 100)


DIES = """
import os, signal, sys
from pathlib import Path
from nsrm_harness.nodes.config import read_config
from nsrm_harness.nodes.ports import FeedbackOut, RobotServices
held = FeedbackOut(RobotServices(read_config(Path(sys.argv[1])), "controller"))
os.kill(os.getpid(), signal.SIGKILL)
"""


def die(place: Path) -> None:
    """Has a controller take its places and be killed."""
    died = subprocess.run([sys.executable, "-c", DIES, str(place)], check=False)
    assert died.returncode == -signal.SIGKILL


def test_a_dead_ones_place_is_free(place: Path) -> None:
    die(place)
    heir = FeedbackOut(RobotServices(read_config(place), "controller"))
    who = rf"`feedback`: all slots are taken; .* or stop process {os.getpid()}$"
    with pytest.raises(PortError, match=who):
        FeedbackOut(RobotServices(read_config(place), "controller"))
    # Nobody else goes by that name.
    with pytest.raises(PortError, match=r"or stop the process that holds it$"):
        FeedbackOut(RobotServices(read_config(place), "camera"))
    del heir


def test_who_is_there_already_takes_a_dead_ones_place(place: Path) -> None:
    robot = RobotServices(read_config(place), "controller")
    die(place)
    # Nobody has buried it: it is found when its place is wanted.
    heir = FeedbackOut(robot)
    del heir


class Sent:
    """A robot with one port, which remembers the times of heartbeats."""

    def __init__(self) -> None:
        self.times_ns: list[int] = []

    def publisher(self, service: str, message: type[Heartbeat]) -> Sent:
        assert (service, message) == ("heartbeat", Heartbeat)
        return self

    def send_copy(self, beat: Heartbeat) -> None:
        self.times_ns.append(beat.timestamp_ns)


def test_a_clock_that_is_set_back_silences_nobody(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    now_ns = [NOW_NS]
    monkeypatch.setattr("nsrm_harness.nodes.ports._clock", lambda: now_ns[0])
    sent = Sent()
    life = Heartbeats(cast(Any, sent), Role.CONTROLLER)
    hour_ns = 3600 * LINE_NS
    times_ns = [NOW_NS, NOW_NS + BEAT_NS - 1, NOW_NS + BEAT_NS]
    for now_ns[0] in [*times_ns, *(time_ns - hour_ns for time_ns in times_ns)]:
        life.beat(State.IDLE)
    due_ns = [NOW_NS, NOW_NS + BEAT_NS]
    assert sent.times_ns == [*due_ns, *(time_ns - hour_ns for time_ns in due_ns)]
    for now_ns[0] in (NOW_NS, NOW_NS + LINE_NS - 1, NOW_NS - hour_ns, NOW_NS - hour_ns + 1):
        life.reject("sub_goal", "command 0")
    assert [record.getMessage() for record in caplog.records] == [
        f"sub_goal rejected: command 0 ({count} so far)" for count in (1, 3)
    ]
