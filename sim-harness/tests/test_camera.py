"""The pinhole camera, its view of the workspace, and what is read from a mask."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from nsrm_harness.geometry.camera import FAR_M, NEAR_M, Camera, default_camera, linear_depth
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.layout import PLACEMENT_SPACE, WORK_SPACE
from nsrm_harness.simulation.render import Surfaces
from nsrm_harness.simulation.segmentation import MIN_VISIBLE_PX, segmented_objects


def test_the_image_has_the_world_the_right_way_round():
    camera = default_camera()
    assert (camera.width, camera.height) == (640, 480)
    middle = camera.project((0.5, 0.0, 0.0))
    assert camera.project((0.5, 0.1, 0.0))[0] > middle[0], "+y is to the right"
    assert camera.project((0.6, 0.0, 0.0))[1] > middle[1], "towards the camera is down"
    assert camera.project((0.5, 0.0, 0.1))[1] < middle[1], "up is up"
    assert camera.project((0.6, 0.0, 0.0))[2] < middle[2], "and nearer"


def test_the_optical_axis_meets_the_target():
    camera = Camera.looking_at(
        (1.0, 0.4, 0.7), (0.2, -0.1, 0.05), width=320, height=200, focal_px=300
    )
    u, v, depth = camera.project((0.2, -0.1, 0.05))
    assert (u, v) == pytest.approx((160, 100), abs=1e-9)
    assert depth == pytest.approx(math.dist((1.0, 0.4, 0.7), (0.2, -0.1, 0.05)))
    assert np.linalg.norm(camera.orientation) == pytest.approx(1)


@pytest.mark.parametrize("seed", range(8))
def test_quaternion_and_matrix_agree_for_any_view(seed: int):
    rng = np.random.default_rng(seed)
    position, target = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
    camera = Camera.looking_at(tuple(position), tuple(target), width=64, height=48, focal_px=50)
    forward = (target - position) / np.linalg.norm(target - position)
    np.testing.assert_allclose(camera.pose.rotation()[:, 2], forward, atol=1e-12)
    assert camera.pose.rotation()[2, 1] < 0, "the image's down is downward"
    assert camera.pose.rotation()[2, 0] == pytest.approx(0, abs=1e-12), "no roll"


def test_straight_down_is_refused():
    with pytest.raises(ValueError, match="straight"):
        Camera.looking_at((0, 0, 1), (0, 0, 0), width=4, height=4, focal_px=4)


def test_back_projection_undoes_projection():
    camera = default_camera()
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (20, 3)) + np.array([0.4, 0, 0])
    np.testing.assert_allclose(camera.back_project(camera.project(points)), points, atol=1e-12)


def test_the_matrices_give_the_projection():
    camera = Camera(
        200, 100, 150.0, 170.0, 90.0, 60.0, (1.0, 0.2, 0.9), default_camera().orientation
    )
    point = np.array([0.4, 0.1, 0.05])
    u, v, depth = camera.project(point)
    clip = camera.projection_matrix() @ camera.view_matrix() @ [*point, 1.0]
    x, y, z = clip[:3] / clip[3]
    assert ((x + 1) / 2 * 200, (1 - y) / 2 * 100) == pytest.approx((u, v))
    assert linear_depth(np.array([(z + 1) / 2], dtype=np.float32))[0] == pytest.approx(depth, 1e-5)
    assert linear_depth(np.array([0.0, 1.0], dtype=np.float32)) == pytest.approx([NEAR_M, FAR_M])


def test_every_block_of_the_work_space_is_seen_whole():
    """The corners of the largest block at each corner of the space, at any yaw."""
    camera = default_camera()
    half_diagonal = math.hypot(0.03, 0.03)
    for corner in itertools.product(*zip(WORK_SPACE.min, WORK_SPACE.max, strict=True)):
        for yaw in np.linspace(0, 2 * math.pi, 16):
            offset = half_diagonal * np.array([math.cos(yaw), math.sin(yaw)])
            for height in (-0.025, 0.025):
                z = max(0.0, corner[2] + height)
                u, v, depth = camera.project((*(np.array(corner[:2]) + offset), z))
                assert 2 < u < 638 and 2 < v < 478
                assert NEAR_M < depth < FAR_M


def test_small_blocks_are_wide_enough_to_be_recognised():
    camera = default_camera()
    for x in (PLACEMENT_SPACE.min[0], PLACEMENT_SPACE.max[0]):
        left, right = camera.project([(x, -0.02, 0.02), (x, 0.02, 0.02)])
        assert right[0] - left[0] >= 30


def test_boxes_and_depths_are_those_of_the_mask():
    mask = np.zeros((48, 64), dtype=np.int32)
    mask[10:20, 4:12] = 3
    mask[40:48, 50:64] = 7
    mask[0, 0 : MIN_VISIBLE_PX - 1] = 9
    depth = np.full(mask.shape, 2.0, dtype=np.float32)
    depth[mask == 3] = 0.5
    depth[10:15, 4:12] = 1.0
    seen = segmented_objects(Surfaces(depth, mask))
    assert seen.ids == (3, 7), "9 is too small to be seen"
    np.testing.assert_array_equal(
        seen.boxes,
        np.array([[4 / 64, 10 / 48, 12 / 64, 20 / 48], [50 / 64, 40 / 48, 1, 1]], dtype=np.float32),
    )
    np.testing.assert_array_equal(seen.depths, np.array([0.75, 2.0], dtype=np.float32))


def test_an_empty_table_gives_an_empty_observation():
    mask = np.zeros((4, 4), dtype=np.int32)
    seen = segmented_objects(Surfaces(np.ones((4, 4), np.float32), mask))
    assert seen.ids == ()
    assert seen.boxes.shape == (0, 4) and seen.depths.shape == (0,)


def test_a_scaled_camera_sees_the_same():
    camera = default_camera()
    point = (0.5, 0.1, 0.03)
    u, v, depth = camera.project(point)
    assert camera.scaled(2).project(point) == pytest.approx([2 * u, 2 * v, depth])
    assert camera.pose == Pose(camera.position, camera.orientation)
