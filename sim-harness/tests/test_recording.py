"""Recordings: what can be read back, and when none is left."""

from __future__ import annotations

import errno
import json
import subprocess
import sys
from collections import defaultdict
from contextlib import closing
from dataclasses import dataclass
from datetime import timedelta
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness_command import run
from PIL import Image
from rerun.chunk import RrdReader

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.camera import FAR_M, default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.bodies import link_convex_hulls
from nsrm_harness.manipulation.robot_interface import wait
from nsrm_harness.perception.observer import ObjectNames, Observation
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.visualization.recording.episode import Recording
from nsrm_harness.visualization.recording.file import RecordingError, recorded
from nsrm_harness.visualization.recording.motion import SAMPLE_S
from nsrm_harness.visualization.recording.timeline import TIMELINE
from nsrm_harness.visualization.recording.view import DEPTH_UNITS, depth_units

SEED = 4
SENTENCE = "put the small red block on the magenta block"
UNKNOWN = "put the purple block on the magenta block"

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Row:
    """What was logged at once, by component; `time_s` is None for what never changes."""

    time_s: float | None
    values: dict[str, Any]


def read(path: Path) -> dict[str, list[Row]]:
    """The rows of each entity, in the order of time."""
    rows: dict[str, list[Row]] = defaultdict(list)
    for chunk in RrdReader(path).stream().to_chunks():
        assert set(chunk.timeline_names) <= {TIMELINE}
        for values in chunk.to_record_batch().to_pylist():
            time: timedelta | None = values.pop(TIMELINE, None)
            here = {name: value for name, value in values.items() if value is not None}
            time_s = None if time is None else time.total_seconds()
            rows[chunk.entity_path].append(Row(time_s, here))
    return {entity: sorted(of, key=lambda row: row.time_s or 0.0) for entity, of in rows.items()}


def times(rows: list[Row]) -> list[float]:
    return [row.time_s for row in rows if row.time_s is not None]


def texts(rows: list[Row]) -> list[str]:
    return [row.values["TextLog:text"][0] for row in rows]


def scalars(rows: list[Row]) -> np.ndarray:
    """`[n, k]`, of k at once."""
    return np.array([row.values["Scalars:scalars"] for row in rows if row.time_s is not None])


def demo(*arguments: str | int | Path) -> int:
    return run("demo", "--seed", SEED, *arguments)


@dataclass(frozen=True)
class Recorded:
    """A demonstration: what it printed, and what is read back."""

    document: dict[str, Any]
    pictures: Path
    rows: dict[str, list[Row]]


@pytest.fixture(scope="module")
def carried(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """A block that the arm carries to its sub-goal."""
    folder = tmp_path_factory.mktemp("carried")
    path, out = folder / "made" / "here.rrd", folder / "out"
    with pytest.MonkeyPatch.context() as patch:
        printed: list[str] = []
        patch.setattr("click.echo", lambda text, **_: printed.append(text))
        assert demo(SENTENCE, "--out", out, "--record", path, "--json") == 0
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    document = json.loads(printed[0])
    assert document["recording"] == str(path)
    return Recorded(document, out, read(path))


def test_all_that_is_promised_is_there_as_often_as_it_must_be(carried: Recorded) -> None:
    rows = carried.rows
    (step,) = carried.document["steps"]
    # Before the plan and after the motion; what the arm looks at between has not moved since.
    looks = times(rows["/world/camera/rgb"])
    assert len(looks) == 2
    for entity in ("camera/depth", "camera/boxes", "groundings", "camera/groundings"):
        assert times(rows[f"/world/{entity}"])[-2:] == looks, entity
    for entity in ("/plan", "/world/sub_goals/step_1"):
        assert times(rows[entity]) == looks[:1], entity
    for entity in ("/world", "/world/table", "/world/camera"):
        assert [row.time_s for row in rows[entity]] == [None]
    moments = times(rows["/distances/nearest_m"])
    links = [f"/world/arm/{link}" for link in link_convex_hulls()]
    for entity in ("/hand/opening_m", "/joints/speeds_rad_s", *links):
        assert times(rows[entity]) == moments, entity
    assert texts(rows["/events"])[:-1] == [
        f"sentence: {SENTENCE}",
        *("reached", "grasped", "lifted", "above", "let go", "home"),
    ]
    assert texts(rows["/events"])[-1].startswith(f"step 1: object {step['object_id']} (")
    # Seen, without what is held, let go, seen again.
    assert len(rows["/world/objects"]) == 4
    assert len(rows["/world/arm/panda_hand/held"]) == 2


def test_time_goes_on_to_the_end(carried: Recorded) -> None:
    moments = np.array(times(carried.rows["/distances/nearest_m"]))
    steps_s = np.diff(moments)
    assert (steps_s > 0).all()
    assert np.allclose(steps_s[1:-1], SAMPLE_S, atol=1e-6) and steps_s.max() < SAMPLE_S + 1e-6
    assert moments[0] == times(carried.rows["/events"])[0]
    # The fingers need some time besides the motions.
    motion_s = carried.document["steps"][0]["outcome"]["motion_s"]
    assert motion_s < moments[-1] - moments[0] < motion_s + 2.0
    assert moments[-1] == times(carried.rows["/world/camera/rgb"])[-1]
    assert moments[-1] == times(carried.rows["/events"])[-1]


def test_the_camera_is_as_it_was_and_its_pictures_are_whole(carried: Recorded) -> None:
    camera, rows = default_camera(), carried.rows
    (fixed,) = [row.values for row in rows["/world/camera"]]
    # Column by column.
    assert fixed["Pinhole:image_from_camera"][0] == [
        *(camera.fx, 0.0, 0.0),
        *(0.0, camera.fy, 0.0),
        *(camera.cx, camera.cy, 1.0),
    ]
    assert np.allclose(fixed["Transform3D:translation"][0], camera.position)
    assert np.allclose(fixed["Transform3D:quaternion"][0], camera.orientation)
    picture = picture_in(rows["/world/camera/rgb"][0].values["EncodedImage:blob"])
    with Image.open(carried.pictures / "camera.png") as taken:
        assert np.array_equal(picture, np.asarray(taken))
    depth = picture_in(rows["/world/camera/depth"][0].values["EncodedDepthImage:blob"])
    depth_m = depth / rows["/world/camera/depth"][0].values["EncodedDepthImage:meter"][0]
    scene = json.loads((carried.pictures / "scene.json").read_text(encoding="utf-8"))
    boxes = rows["/world/camera/boxes"][0].values
    assert len(boxes["Boxes2D:centers"]) == len(scene["objects"])
    for found, centre in zip(scene["objects"], boxes["Boxes2D:centers"], strict=True):
        x1, y1, x2, y2 = np.array(found["box"]) * (640, 480, 640, 480)
        assert centre == pytest.approx([(x1 + x2) / 2, (y1 + y2) / 2], abs=1e-3)
        column, row = (int(value) for value in centre)
        # A block's middle is about as far away as all of it.
        assert depth_m[row, column] == pytest.approx(found["depth"], abs=0.03)


def picture_in(blob: Any) -> np.ndarray:
    with Image.open(BytesIO(bytes(blob[0]))) as image:
        return np.asarray(image)


def test_what_is_said_and_where_it_goes(carried: Recorded) -> None:
    (step,), rows = carried.document["steps"], carried.rows
    plan = rows["/plan"][0].values["TextDocument:text"][0]
    assert SENTENCE in plan and carried.document["program"] in plan
    grounded = rows["/world/groundings"][0].values
    moved, reference = grounded["Boxes3D:labels"]
    assert moved == f"{step['object_id']}: step 1 moves"
    assert reference == f"{step['reference_id']}: step 1 refers to"
    goal = rows["/world/sub_goals/step_1"][0].values
    assert np.allclose(goal["Transform3D:translation"][0], step["sub_goal"]["position"])
    # In the end the block is seen there, and the arm is at rest in its ready pose.
    last = rows["/world/groundings"][-1].values["Boxes3D:centers"][0]
    assert np.linalg.norm(np.subtract(last, goal["Transform3D:translation"][0])) < 0.01
    speeds = scalars(rows["/joints/speeds_rad_s"])
    assert speeds.shape[1] == panda.JOINTS
    assert np.abs(speeds[-1]).max() < 0.01 < np.abs(speeds).max() < panda.MAX_SPEED_RAD_S.max()


def test_the_hand_holds_what_it_carries_and_touches_it_alone(carried: Recorded) -> None:
    rows = carried.rows
    at = dict(zip(texts(rows["/events"]), times(rows["/events"]), strict=True))
    opening = scalars(rows["/hand/opening_m"])[:, 0]
    distance = scalars(rows["/distances/nearest_m"])[:, 0]
    moments = np.array(times(rows["/distances/nearest_m"]))
    carrying = (moments > at["lifted"]) & (moments < at["above"])
    assert opening[carrying].min() > 0.03 and np.ptp(opening[carrying]) < 0.001
    assert distance[carrying].min() > 0.001
    touching = (moments > at["grasped"]) & (moments < at["grasped"] + 2 * SAMPLE_S)
    assert distance[touching].max() < 0.001
    held, released = rows["/world/arm/panda_hand/held"]
    (number,) = {step["object_id"] for step in carried.document["steps"]}
    assert held.values["Boxes3D:labels"][0].startswith(f"object {number} (")
    assert released.values["Clear:is_recursive"] == [False]
    assert at["grasped"] == held.time_s
    assert at["above"] < (released.time_s or 0.0) < at["let go"]
    # It hangs between the fingers' ends.
    assert held.values["Boxes3D:centers"][0][:2] == pytest.approx([0.0, 0.0], abs=0.005)
    assert held.values["Boxes3D:centers"][0][2] == pytest.approx(panda.FINGERTIP_M, abs=0.03)


@pytest.mark.parametrize("opens", [True, False])
def test_what_the_fingers_lose_is_no_longer_drawn_until_it_is_seen(
    tmp_path: Path, opens: bool
) -> None:
    path, cube = tmp_path / "lost.rrd", Cuboid(Pose((0.5, 0.0, 0.02)), (0.04, 0.04, 0.04))
    image, depth = np.zeros((480, 640, 3), np.uint8), np.ones((480, 640), np.float32)
    with recorded(path) as stream, closing(ArmWorld()) as world:
        recording = Recording(stream)
        recording.begin(world, default_camera(), ObjectNames({}, {}), "")
        for taken_s in (0.0, 1.0):
            labels = np.zeros((480, 640), np.int32)
            sight = Observation(image, depth, labels, {}, {}, frozenset(), {7: cube}, taken_s)
            recording.looked(sight)
            if taken_s == 0.0:
                world.grip(0.04, panda.GRIP_N)
                wait(world, 0.5)
                recording.mark("grasped")
                world.grip(0.06 if opens else 0.0, panda.GRIP_N)
                wait(world, 0.5)
        recording.end()
    rows = read(path)
    assert len(rows["/world/arm/panda_hand/held"]) == 2
    drawn = [len(row.values.get("Boxes3D:centers", [])) for row in rows["/world/objects"]]
    assert drawn == [1, 0, 1 if opens else 0, 1]


def test_a_refused_sentence_leaves_the_scene_and_the_reason(tmp_path: Path) -> None:
    path = tmp_path / "refused.rrd"
    assert demo(UNKNOWN, "--out", tmp_path / "out", "--record", path) == 2
    rows = read(path)
    said, refusal = rows["/events"]
    assert said.values["TextLog:text"] == [f"sentence: {UNKNOWN}"]
    assert refusal.values["TextLog:level"] == ["ERROR"]
    assert refusal.values["TextLog:text"][0].startswith("refused: ")
    assert "purple" in refusal.values["TextLog:text"][0]
    assert "purple" in rows["/plan"][0].values["TextDocument:text"][0]
    for entity in ("camera/rgb", "camera/depth", "camera/boxes", "objects", "arm/panda_link1"):
        assert len(times(rows[f"/world/{entity}"])) == 1, entity
    assert not any("groundings" in entity or "sub_goals" in entity for entity in rows)


def test_without_the_arm_it_stands_still(tmp_path: Path) -> None:
    path = tmp_path / "set_down.rrd"
    assert demo(SENTENCE, "--no-arm", "--out", tmp_path / "out", "--record", path) == 0
    rows = read(path)
    assert len(times(rows["/world/camera/rgb"])) == len(times(rows["/world/arm/panda_hand"])) == 2
    assert "comes to rest" in texts(rows["/events"])[-1]
    assert not any(entity.startswith(("/joints", "/hand", "/distances")) for entity in rows)


@pytest.mark.parametrize(
    ("name", "why"),
    [("file/below.rrd", "another --record"), ("folder.rrd", "Is a directory"), ("a.txt", ".rrd")],
)
def test_what_cant_be_written_is_refused_before_anything_is_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, why: str
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder.rrd").mkdir()
    assert demo("--out", tmp_path / "out", "--record", tmp_path / name) == 2
    assert why in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.rrd"]


def test_what_fails_leaves_the_file_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.rrd"
    path.write_text("before", encoding="utf-8")
    with pytest.raises(KeyboardInterrupt), recorded(path):
        raise KeyboardInterrupt

    def write(self: Path, _: bytes) -> int:
        self.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch, pytest.raises(RecordingError, match="No space"):
        patch.setattr(Path, "write_bytes", write)
        with recorded(path):
            pass
    assert path.read_text(encoding="utf-8") == "before"
    assert [file.name for file in tmp_path.iterdir()] == ["a.rrd"]


def test_a_recording_that_is_turned_off_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(RecordingError, match="RERUN"), recorded(tmp_path / "a.rrd"):
        pytest.fail("nothing would be written")
    assert not list(tmp_path.iterdir())


def test_without_the_package_it_is_told_what_to_do(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['rerun'] = None\n"
        "from nsrm_harness.cli.main import main\n"
        f"main(['demo', '--out', {str(tmp_path / 'out')!r}, '--record', 'a.rrd'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "rerun-sdk" in done.stderr and "record.txt" in done.stderr
    assert not list(tmp_path.iterdir())


def test_depths_fit_into_16_bits() -> None:
    assert FAR_M * DEPTH_UNITS < 2**16
    depth = np.array([[np.nan, np.inf, -np.inf, -1.0], [0.0, 0.5, FAR_M, 40.0]], np.float32)
    assert depth_units(depth).tolist() == [[0] * 4, [0, 5000, FAR_M * DEPTH_UNITS, 65535]]
