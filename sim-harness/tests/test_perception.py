"""The detector: what it must find, what it must not, and what it refuses."""

from __future__ import annotations

import ast
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness_command import run
from world_scenes import DOMAIN, build_scene

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.evaluation.detector.match import match, overlaps
from nsrm_harness.evaluation.detector.measure import measure
from nsrm_harness.evaluation.detector.scenes import Picture, with_noise
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.perception.detector import Detections, detect
from nsrm_harness.perception.observer import Observer
from nsrm_harness.perception.relief import PerceptionError, Relief, relief
from nsrm_harness.simulation.blocks import block_from_attributes
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.simulation.segmentation import SegmentedImage, render_segmented
from nsrm_harness.simulation.simulated_camera import SimulatedCamera
from nsrm_harness.simulation.world import World

CAMERA = default_camera()
PACKAGE = Path(__file__).parent.parent / "nsrm_harness" / "perception"
#: A box is right when each side is within so many pixels of the mask's.
SIDE_PX = 1.5
DEPTH_M = 0.0005


def put(world: World, blocks: Sequence[tuple[str, str, float, float, float, float]]) -> None:
    """Blocks where they are said to be, without physics: colour, size, x, y, height of
    the lower face, yaw in degrees."""
    world.reset()
    made = [block_from_attributes(DOMAIN, {"color": c, "size": s}) for c, s, *_ in blocks]
    poses = [
        Pose.upright(x, y, z + block.edges_m[2] / 2, math.radians(yaw))
        for block, (_, _, x, y, z, yaw) in zip(made, blocks, strict=True)
    ]
    world.spawn(made, poses)


def look(renderer: Renderer, world: World, light: Light | None = None) -> SegmentedImage:
    return render_segmented(renderer, world, CAMERA, light or Light())


def side_errors_px(found: Detections, seen: SegmentedImage) -> np.ndarray:
    """Largest distance of a side from the mask's, for each detection, all matched."""
    rows = match(found.boxes, seen.boxes)
    assert sorted(rows) == list(range(len(seen.boxes))), f"{len(found)} found: {rows}"
    errors = np.abs(found.boxes - seen.boxes[rows]) * (640, 480, 640, 480)
    return errors.max(axis=1)


def check(renderer: Renderer, world: World, light: Light | None = None) -> None:
    """Finds exactly what the mask shows, to the pixel."""
    seen = look(renderer, world, light)
    found = detect(seen.rgb, seen.depth, CAMERA)
    errors = side_errors_px(found, seen)
    assert errors.max() <= SIDE_PX, errors
    depths = seen.depths[match(found.boxes, seen.boxes)]
    np.testing.assert_allclose(found.depths, depths, atol=DEPTH_M)


@pytest.mark.parametrize("seed", range(8))
def test_scenes_under_any_light(renderer: Renderer, world: World, seed: int) -> None:
    build_scene(world, seed)
    check(renderer, world, Light.sample(np.random.default_rng(seed)))


@pytest.mark.parametrize("seed", range(20, 28))
def test_towers_of_any_colours(renderer: Renderer, world: World, seed: int) -> None:
    build_scene(world, seed, tower=1 + seed % 3)
    seen = look(renderer, world, Light.sample(np.random.default_rng(seed)))
    found = detect(seen.rgb, seen.depth, CAMERA)
    errors = side_errors_px(found, seen)
    # A sliver of a lower block beside the upper one may be lost.
    assert np.median(errors) <= SIDE_PX, errors
    assert overlaps(found.boxes, seen.boxes).max(axis=1).min() > 0.75


@pytest.mark.parametrize("size", ["small", "lego"])
def test_a_block_that_a_nearer_one_divides_is_one(
    renderer: Renderer, world: World, size: str
) -> None:
    front = [("blue", "small", 0.48, 0.0, z, 0.0) for z in (0.0, 0.04, 0.08)]
    put(world, [("red", "lego", 0.4, 0.0, 0, 0), *front])
    check(renderer, world)
    # Two blocks, a hidden gap between them.
    put(world, [("red", size, 0.4, -0.036, 0, 0), ("red", size, 0.4, 0.036, 0, 0), *front])
    check(renderer, world)


@pytest.mark.parametrize("color", ["red", "white"])
@pytest.mark.parametrize(("dx", "dy"), [(0.0, 0.052), (0.052, 0.0), (0.035, 0.053)])
def test_a_gap_of_12_mm_between_blocks_of_one_colour(
    renderer: Renderer, world: World, color: str, dx: float, dy: float
) -> None:
    put(world, [(color, "small", 0.4, 0.1, 0, 0), (color, "small", 0.4 + dx, 0.1 + dy, 0, 0)])
    check(renderer, world)


@pytest.mark.parametrize(
    "sizes",
    [
        ("small", "small"),
        ("lego", "lego"),
        ("lego", "small"),
        ("small", "lego"),
        ("small", "small", "small"),
        ("lego", "lego", "lego"),
        ("lego", "small", "small"),
        ("small", "lego", "small"),
        ("small", "small", "lego"),
        ("lego", "small", "lego", "small"),
    ],
)
def test_stacks_of_one_colour(renderer: Renderer, world: World, sizes: tuple[str, ...]) -> None:
    blocks, z = [], 0.0
    for size in sizes:
        blocks.append(("green", size, 0.5, -0.1, z, 0.0))
        z += 0.05 if size == "lego" else 0.04
    put(world, blocks)
    seen = look(renderer, world)
    errors = side_errors_px(detect(seen.rgb, seen.depth, CAMERA), seen)
    # Where nothing shows the seam, its place is that of equal heights.
    assert errors.max() <= 3.5, errors


def test_a_block_behind_another_has_the_box_of_what_is_seen(
    renderer: Renderer, world: World
) -> None:
    put(
        world,
        [
            ("red", "lego", 0.55, 0.0, 0, 0),
            ("blue", "small", 0.55, 0.0, 0.05, 5),
            ("red", "small", 0.47, 0.0, 0, -8),
            ("blue", "small", 0.45, -0.06, 0, 10),
        ],
    )
    seen = look(renderer, world)
    hidden_edge_px = CAMERA.project((0.49, 0.0, 0.0))[1]
    assert seen.boxes[2, 3] * CAMERA.height < hidden_edge_px - 5
    check(renderer, world)


@pytest.mark.parametrize("noise_m", [0.0, 0.001, 0.002])
def test_noise_and_missing_depth(renderer: Renderer, world: World, noise_m: float) -> None:
    pictures = []
    for seed in range(6):
        build_scene(world, seed)
        seen = look(renderer, world, Light.sample(np.random.default_rng(seed)))
        pictures.append(Picture(seen.rgb, seen.depth, CAMERA, seen.boxes, seen.depths))
    figures, _ = measure(with_noise(pictures, noise_m, 0.01, seed=1))
    assert figures.recall_50 == 1.0
    assert figures.precision_50 == 1.0
    assert figures.mean_iou is not None and figures.mean_iou > (0.97 if noise_m else 0.99)
    assert figures.depth_error_m is not None and figures.depth_error_m < DEPTH_M


@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf, -1.0])
def test_what_was_not_measured_is_the_same_whatever_stands_there(
    renderer: Renderer, world: World, nothing: float
) -> None:
    """Neighbouring infinities made the noise NaN, and rough depth was not smoothed."""
    build_scene(world, 2)
    seen = look(renderer, world)
    rng = np.random.default_rng(5)
    depth = (seen.depth + rng.normal(0.0, 0.003, seen.depth.shape)).astype(np.float32)
    # Most of a band as far sensors leave it, and single pixels everywhere.
    holes = rng.random(depth.shape) < 0.02
    holes[:120] |= rng.random((120, depth.shape[1])) < 0.9
    expected = detect(seen.rgb, np.where(holes, np.float32(0.0), depth), CAMERA)
    found = detect(seen.rgb, np.where(holes, np.float32(nothing), depth), CAMERA)
    np.testing.assert_array_equal(found.labels, expected.labels)
    np.testing.assert_array_equal(found.boxes, expected.boxes)
    np.testing.assert_array_equal(found.depths, expected.depths)


def test_the_heights_of_a_picture_are_taken_once_a_look(
    renderer: Renderer, world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_scene(world, 2)
    taken: list[Relief] = []

    def counted(*arguments: Any) -> Relief:
        taken.append(relief(*arguments))
        return taken[-1]

    for module in ("nsrm_harness.perception.observer", "nsrm_harness.perception.detector"):
        monkeypatch.setattr(f"{module}.relief", counted)
    observer = Observer(SimulatedCamera(renderer, world, CAMERA))
    for looks in (1, 2):
        observer.look()
        assert len(taken) == looks


def test_figures_of_what_was_found_are_absent_where_nothing_was(renderer: Renderer) -> None:
    with World() as empty:
        seen = look(renderer, empty)
    true = np.array([[0.4, 0.4, 0.5, 0.5]], np.float32)
    picture = Picture(seen.rgb, seen.depth, CAMERA, true, np.ones(1, np.float32))
    figures, _ = measure([picture])
    assert (figures.objects, figures.recall_50) == (1, 0.0)
    # No detection is wrong where there is none.
    assert figures.precision_50 is None and figures.precision_75 is None
    assert figures.mean_iou is None and figures.depth_error_m is None
    assert figures.place_error_m is None and figures.place_error_p95_m is None
    assert json.loads(json.dumps(figures.as_json(), allow_nan=False))["mean_iou"] is None
    assert "recall 0.0000, precision -" in str(figures)
    assert "mean IoU -, depth error -, position error - (p95 -)" in str(figures)


@pytest.mark.parametrize("robot", [True, False])
def test_nothing_is_found_on_an_empty_table(renderer: Renderer, robot: bool) -> None:
    with World(robot=robot) as empty:
        seen = look(renderer, empty)
        found = detect(seen.rgb, seen.depth, CAMERA)
        assert len(found) == 0
        assert found.boxes.shape == (0, 4)
        assert not found.labels.any()
        assert len(match(found.boxes, np.zeros((2, 4), np.float32))) == 0
        noisy = next(
            with_noise([Picture(seen.rgb, seen.depth, CAMERA, *empty_truth())], 0.002, 0.01, 0)
        )
        assert len(detect(noisy.image, noisy.depth, CAMERA)) == 0


def empty_truth() -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((0, 4), np.float32), np.zeros(0, np.float32)


def test_a_camera_pose_that_is_off_by_millimetres_costs_nothing(
    renderer: Renderer, world: World
) -> None:
    build_scene(world, 3)
    seen = look(renderer, world)
    x, y, z = CAMERA.position
    moved = replace(CAMERA, position=(x + 0.002, y - 0.002, z + 0.004))
    assert side_errors_px(detect(seen.rgb, seen.depth, moved), seen).max() <= SIDE_PX


def test_labels_depths_and_boxes_say_the_same(renderer: Renderer, world: World) -> None:
    build_scene(world, 4, tower=2)
    seen = look(renderer, world)
    found = detect(seen.rgb, seen.depth, CAMERA)
    assert found.labels.dtype == np.int32
    assert found.boxes.dtype == found.depths.dtype == np.float32
    assert set(np.unique(found.labels)) == set(range(len(found) + 1))
    for row in range(len(found)):
        rows, columns = np.nonzero(found.labels == row + 1)
        box = (
            columns.min() / 640,
            rows.min() / 480,
            (columns.max() + 1) / 640,
            (rows.max() + 1) / 480,
        )
        np.testing.assert_allclose(found.boxes[row], box, atol=1e-6)
        np.testing.assert_allclose(found.depths[row], seen.depth[rows, columns].mean(), atol=1e-5)
    assert (np.diff(found.boxes[:, 0]) >= 0).all()


def test_what_is_no_picture_of_the_camera_is_refused(renderer: Renderer, world: World) -> None:
    build_scene(world, 5)
    seen = look(renderer, world)
    cases: list[tuple[Any, Any, str]] = [
        (seen.rgb[:, :-1], seen.depth, r"image: expected uint8 \[480, 640, 3\].*got .*639"),
        (seen.rgb.astype(np.float32), seen.depth, "image: expected uint8 .* got float32"),
        (seen.rgb, seen.depth[..., None], r"depth: expected float32 \[480, 640\]"),
        (seen.rgb, seen.depth.astype(np.float64), "depth: expected float32 .* got float64"),
        (seen.rgb, 1000 * seen.depth, "no table in view: 0 of"),
        (seen.rgb, np.zeros_like(seen.depth), "no table in view: 0 of"),
        (seen.rgb, np.full_like(seen.depth, np.nan), "no table in view: 0 of"),
    ]
    for image, depth, message in cases:
        with pytest.raises(PerceptionError, match=message):
            detect(image, depth, CAMERA)
    assert issubclass(PerceptionError, HarnessError)


def test_more_objects_than_there_is_room_for_are_refused(renderer: Renderer, world: World) -> None:
    grid = [
        ("red", "small", 0.36 + 0.08 * (i // 6), -0.2 + 0.08 * (i % 6), 0.0, 0.0) for i in range(17)
    ]
    put(world, grid[:16])
    check(renderer, world)
    put(world, grid)
    seen = look(renderer, world)
    with pytest.raises(PerceptionError, match="17 objects in view, at most 16 are supported"):
        detect(seen.rgb, seen.depth, CAMERA)


def test_matching_takes_each_object_once_and_nothing_far() -> None:
    true = np.array([[0.1, 0.1, 0.3, 0.3], [0.5, 0.5, 0.7, 0.7]], dtype=np.float32)
    shifted = true[0] + np.float32(0.02)
    boxes = np.stack([shifted, true[0], [0.8, 0.8, 0.9, 0.9], true[1]]).astype(np.float32)
    found = Detections(boxes, np.ones(4, np.float32), np.zeros((4, 4), np.int32))
    assert match(found.boxes, true).tolist() == [-1, 0, -1, 1]
    assert overlaps(boxes[:1], true)[0, 0] == pytest.approx(
        0.18**2 / (2 * 0.2**2 - 0.18**2), rel=1e-4
    )
    assert match(found.boxes, np.zeros((3, 4), np.float32)).tolist() == [-1] * 4


def test_the_detector_imports_nothing_of_the_simulator() -> None:
    allowed = {"nsrm_harness.common.errors", "nsrm_harness.geometry.camera"}
    for name in ("detector", "relief", "towers", "cuts", "edges"):
        tree = ast.parse((PACKAGE / f"{name}.py").read_text(encoding="utf-8"))
        modules = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        modules |= {
            alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.Import)
            for alias in node.names
        }
        own = {module for module in modules if module.startswith("nsrm_harness.perception.")}
        ours = {module for module in modules if module.startswith("nsrm_harness")}
        assert ours - own <= allowed, name
        assert not {"pybullet", "h5py", "moderngl"} & modules, name


def test_the_command_measures_a_file_and_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, picture = tmp_path / "few.h5", tmp_path / "found.png"

    assert run("episodes", "--split", "test", "--count", 2, "--out", path, "--jobs", 1) == 0
    capsys.readouterr()
    assert run("detect", "--data", path, "--json", "--out", picture) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["scenes"] == 2
    assert figures["recall_75"] == figures["precision_75"] == 1.0
    assert picture.stat().st_size > 10_000
    assert run("detect", "--after", "3-3", "--count", 1, "--noise-mm", 1) == 0
    assert "1 scenes" in capsys.readouterr().out
    assert run("detect", "--data", tmp_path / "none.h5") == 2
    assert "no such episode file" in capsys.readouterr().err
