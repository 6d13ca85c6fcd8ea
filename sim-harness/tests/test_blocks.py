"""Blocks, their meshes, poses and layouts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from world_scenes import DOMAIN, random_blocks

from nsrm_harness.geometry.mesh import load_obj
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.arm import link_visuals
from nsrm_harness.simulation.blocks import STUD_HEIGHT_M, block_from_attributes, block_mesh
from nsrm_harness.simulation.layout import (
    CLEARANCE_M,
    MAX_YAW_RAD,
    PLACEMENT_SPACE,
    WORK_SPACE,
    LayoutError,
    apart,
    footprint,
    sample_layout,
)


def test_a_block_merges_what_its_values_say():
    block = block_from_attributes(DOMAIN, {"size": "lego", "color": "cyan"})
    assert block.edges_m == (0.06, 0.06, 0.05)
    assert block.rgb == (0.10, 0.74, 0.80)
    assert block.studs == (2, 2)
    assert block.values == {"color": "cyan", "size": "lego"}
    assert block_from_attributes(DOMAIN, {"size": "small", "color": "red"}).studs is None


@pytest.mark.parametrize(
    ("attributes", "named"),
    [
        ({"color": "red"}, "size"),
        ({"color": "red", "size": "lego", "shape": "ball"}, "shape"),
        ({"color": "beige", "size": "lego"}, "beige"),
    ],
)
def test_a_block_refuses_what_the_domain_does_not_have(attributes: dict[str, str], named: str):
    with pytest.raises(KeyError, match=named):
        block_from_attributes(DOMAIN, attributes)


@pytest.mark.parametrize("size", ["lego", "small"])
def test_the_mesh_fills_the_edges_and_its_faces_look_outward(size: str):
    block = block_from_attributes(DOMAIN, {"color": "red", "size": size})
    mesh = block_mesh(block)
    low, high = mesh.bounds_m()
    np.testing.assert_allclose(high - low, block.edges_m, atol=1e-7)
    np.testing.assert_allclose(high + low, 0, atol=1e-7)
    a, b, c = (mesh.vertices[mesh.triangles[:, i]].astype(float) for i in range(3))
    crossed = np.cross(b - a, c - a)
    # Winding, normals and flatness: each corner's normal is its triangle's.
    for corner in range(3):
        normals = mesh.normals[mesh.triangles[:, corner]]
        cosine = (normals * crossed).sum(axis=1) / np.linalg.norm(crossed, axis=1)
        np.testing.assert_allclose(cosine, 1.0, atol=1e-4)
    # The divergence theorem gives the volume; inward faces would make it negative.
    # Seen from the studs' feet, which are open, the missing faces count nothing.
    feet = np.array([0.0, 0.0, block.edges_m[2] / 2 - STUD_HEIGHT_M])
    volume = ((a - feet) * crossed).sum() / 6
    ex, ey, ez = block.edges_m
    if block.studs is None:
        expected = ex * ey * ez
    else:
        radius = 0.3 * 0.03
        circle = 16 / 2 * math.sin(2 * math.pi / 16) * radius**2
        expected = ex * ey * (ez - STUD_HEIGHT_M) + 4 * circle * STUD_HEIGHT_M
    assert volume == pytest.approx(expected, rel=1e-5)


def test_the_arm_has_a_mesh_for_each_visible_link():
    visuals = {visual.link: visual for visual in link_visuals()}
    assert {"panda_link0", "panda_link7", "panda_hand", "panda_leftfinger"} <= visuals.keys()
    left, right = visuals["panda_leftfinger"], visuals["panda_rightfinger"]
    # The right finger is the left one turned by half a turn about z.
    np.testing.assert_allclose(right.center, left.center * [-1, -1, 1], atol=1e-6)


def test_an_obj_file_keeps_colours_and_corners(tmp_path: Path):
    (tmp_path / "a.mtl").write_text("newmtl dark\nKd 0.1 0.2 0.3\n")
    path = tmp_path / "a.obj"
    path.write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nvn 0 0 1\nvn 0 -1 0\n"
        "usemtl dark\nf 1/7/1 2/8/1 3/9/1\nusemtl none\nf 1//2 2//2 4//2\n"
    )
    dark, plain = load_obj(path)
    assert (dark.rgb, plain.rgb) == ((0.1, 0.2, 0.3), (1.0, 1.0, 1.0))
    corners = dark.vertices[dark.triangles[0]]
    np.testing.assert_array_equal(corners, [[0, 0, 0], [1, 0, 0], [0, 2, 0]])
    np.testing.assert_array_equal(plain.vertices[plain.triangles[0]][2], [0, 0, 3])
    np.testing.assert_array_equal(plain.normals, [[0, -1, 0]] * 3)


@pytest.mark.parametrize("face", ["1//1 2//1 3//1 4//1", "1/1/1 2/1/1 3/1/1 4/1/1", "1 2 3"])
def test_an_obj_file_with_other_faces_is_refused(tmp_path: Path, face: str):
    path = tmp_path / "square.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf {face}\n")
    with pytest.raises(ValueError, match="triangle"):
        load_obj(path)


def test_poses_turn_and_compare():
    pose = Pose.upright(1.0, 2.0, 3.0, math.radians(30))
    np.testing.assert_allclose(
        pose.rotation() @ [1, 0, 0], [math.cos(math.pi / 6), 0.5, 0], atol=1e-12
    )
    assert pose.yaw_rad() == pytest.approx(math.radians(30))
    negated = Pose(pose.position, tuple(-v for v in pose.orientation))  # type: ignore[arg-type]
    assert pose.angle_rad(negated) == 0.0
    assert pose.angle_rad(Pose.upright(0, 0, 0, math.radians(31))) == pytest.approx(math.radians(1))
    assert pose.angle_rad(Pose((0, 0, 0), (1, 0, 0, 0))) == pytest.approx(math.pi)


def test_apart_measures_the_gap_between_turned_squares():
    square = ((-0.02, -0.02), (0.02, -0.02), (0.02, 0.02), (-0.02, 0.02))
    beside = tuple((x + 0.05, y) for x, y in square)
    within = tuple((x * 0.1, y * 0.1) for x, y in square)
    turned = tuple((x - y + 0.09, x + y) for x, y in square)
    for first, second in ((square, beside), (beside, square)):
        assert apart(first, second, 0.0099)
        assert not apart(first, second, 0.0101)
    assert not apart(square, within, 0.0) and not apart(within, square, 0.0)
    assert apart(square, turned, 0.0299) and apart(turned, square, 0.0299)
    assert not apart(square, turned, 0.0301)


@pytest.mark.parametrize("seed", range(40))
def test_layouts_lie_in_the_space_apart_from_each_other(seed: int):
    rng = np.random.default_rng(seed)
    blocks = random_blocks(rng, 6)
    poses = sample_layout(rng, blocks)
    assert len(poses) == 6
    corners = [footprint(b, p) for b, p in zip(blocks, poses, strict=True)]
    for i, (block, pose) in enumerate(zip(blocks, poses, strict=True)):
        assert PLACEMENT_SPACE.contains(pose.position)
        assert abs(pose.yaw_rad()) <= MAX_YAW_RAD
        assert pose.position[2] == block.edges_m[2] / 2
        for other in range(i):
            assert apart(corners[i], corners[other], CLEARANCE_M)


def test_layouts_repeat_with_their_seed():
    blocks = random_blocks(np.random.default_rng(1), 5)
    first = sample_layout(np.random.default_rng(2), blocks)
    assert first == sample_layout(np.random.default_rng(2), blocks)
    assert first != sample_layout(np.random.default_rng(3), blocks)


def test_too_many_blocks_are_refused_in_bounded_time():
    rng = np.random.default_rng(0)
    with pytest.raises(LayoutError, match="of 60 after"):
        sample_layout(rng, random_blocks(rng, 60))


def test_the_placement_space_lies_inside_the_work_space():
    assert WORK_SPACE.contains(PLACEMENT_SPACE.min) and WORK_SPACE.contains(PLACEMENT_SPACE.max)
