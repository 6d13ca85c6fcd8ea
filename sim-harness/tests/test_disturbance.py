"""Disturbed episodes: the same scenes and programs with another camera and light."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.cli.main import main
from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data.disturbance import UNDISTURBED, Disturbance
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block, block_from_attributes
from nsrm_harness.simulation.render import Light, open_renderer
from nsrm_harness.simulation.render.tiny import MAX_MESHES
from nsrm_harness.simulation.world import World

DOMAIN = domains.load()
SETTINGS = replace(SPLITS["disturbed"], count=2, seed=4, renderer="pybullet")


def make(folder: Path, **sizes: float) -> Path:
    path = folder / f"{'-'.join(sizes) or 'plain'}.h5"
    generate(replace(SETTINGS, disturbance=Disturbance(**sizes)), DOMAIN, path)
    return path


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("plain"))


def differing(first: Path, second: Path) -> set[str]:
    """What of two files with the same scenes and programs is not the same."""
    with (
        Demonstrations(first) as a,
        Demonstrations(second) as b,
        GroundTruth(first) as left,
        GroundTruth(second) as right,
    ):
        assert a.sentences == b.sentences
        for index in range(len(a)):
            one, other = left.truth(index), right.truth(index)
            assert (one.attributes, one.program) == (other.attributes, other.program)
            assert one.initial_poses == other.initial_poses
        pairs = {
            "image": (a.initial_image(0), b.initial_image(0)),
            "depth image": (a.initial_depth(0), b.initial_depth(0)),
            "boxes": (a.initial_boxes, b.initial_boxes),
            "depths": (a.initial_depths, b.initial_depths),
            "camera": (a.cameras, b.cameras),
        }
    return {name for name, pair in pairs.items() if not np.array_equal(*pair)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ({"light": 0.2}, {"image"}),
        ({"color": 0.2}, {"image"}),
        ({"depth_m": 0.002}, {"depth image", "depths"}),
        ({"camera_m": 0.01}, {"image", "depth image", "boxes", "depths", "camera"}),
        ({"camera_deg": 1.0}, {"image", "depth image", "boxes", "depths", "camera"}),
    ],
)
def test_each_disturbs_what_it_says_and_nothing_else(
    sizes: dict[str, float], expected: set[str], plain: Path, tmp_path: Path
) -> None:
    assert differing(plain, make(tmp_path, **sizes)) == expected


def test_the_camera_stays_within_what_is_said() -> None:
    camera, rng = default_camera(), np.random.default_rng(5)
    moved = [Disturbance(camera_m=0.01, camera_deg=1.0).moved(camera, rng) for _ in range(200)]
    shifts = np.array([np.subtract(each.position, camera.position) for each in moved])
    turns = np.degrees([each.pose.angle_rad(camera.pose) for each in moved])
    assert 0.009 < np.abs(shifts).max() <= 0.01
    assert 0.9 < turns.max() <= 1.0 + 1e-9
    assert UNDISTURBED.moved(camera, rng) == camera


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["auto", "pybullet"])
def test_many_colors_leave_pictures_as_they_were(kind: str) -> None:
    block = block_from_attributes(DOMAIN, {a.name: a.values[0].name for a in DOMAIN.attributes})
    renderer = open_renderer(kind)
    camera, light = default_camera(), Light()

    def picture(world: World, shown: Block) -> np.ndarray:
        world.reset()
        world.spawn([shown], [Pose.upright(0.5, 0.0, block.edges_m[2] / 2)])
        return renderer.render(world, camera, light).rgb

    with World(robot=False) as world:
        before = picture(world, block)
        for number in range(MAX_MESHES + 3):
            world.reset()
            world.spawn(
                [replace(block, rgb=(number / 1000, 0.5, 0.5))],
                [Pose.upright(0.5, 0.0, block.edges_m[2] / 2)],
            )
            renderer.surfaces(world, camera)
        assert np.array_equal(picture(world, block), before)
    renderer.close()


def test_sizes_that_make_no_sense_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for size in (-0.1, float("nan"), float("inf")):
        with pytest.raises(EpisodeSettingsError, match=f"light: expected 0 or more, got {size}"):
            make(tmp_path, light=size)
    for value, problem in (("fog=1", "'fog': expected some of camera_m"), ("light=x", "a number")):
        with pytest.raises(SystemExit) as caught:
            main(["episodes", "--split", "test", "--disturbance", value])
        assert caught.value.code == 2
        assert problem in capsys.readouterr().err
