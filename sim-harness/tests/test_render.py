"""Both renderers, compared with ray casting and with each other."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np
import pytest
from another_process import elsewhere
from numpy.typing import NDArray
from world_scenes import DOMAIN, build_scene, require_gl

from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_from_attributes
from nsrm_harness.simulation.layout import WORK_SPACE
from nsrm_harness.simulation.render import VARIABLE, Light, Renderer, RendererError, open_renderer
from nsrm_harness.simulation.segmentation import render_segmented, segmented_image
from nsrm_harness.simulation.world import World

KINDS = ["gl", "pybullet"]


@pytest.fixture(scope="module")
def renderers() -> Iterator[dict[str, Renderer]]:
    opened: dict[str, Renderer] = {"pybullet": open_renderer("pybullet")}
    yield opened
    for renderer in opened.values():
        renderer.close()


def get(renderers: dict[str, Renderer], kind: str) -> Renderer:
    if kind not in renderers:
        renderers[kind] = require_gl()
    return renderers[kind]


def cast(camera: Camera, pose: Pose, edges_m: tuple[float, float, float]) -> NDArray[np.float64]:
    """Depth `[H, W]` of a cuboid along each pixel's ray; infinite where it is missed."""
    columns, rows = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    ones = np.ones_like(columns)
    local = [(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, ones]
    rays = np.stack(local, axis=-1) @ camera.pose.rotation().T @ pose.rotation()
    origin = (np.array(camera.position) - pose.position) @ pose.rotation()
    half = np.array(edges_m) / 2
    first, second = (-half - origin) / rays, (half - origin) / rays
    entry = np.minimum(first, second).max(axis=-1)
    leave = np.maximum(first, second).min(axis=-1)
    return np.where(entry <= leave, entry, np.inf)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("focal", [(936.0, 936.0, 320.0, 240.0), (800.0, 850.0, 331.0, 222.5)])
def test_mask_and_depth_are_those_of_ray_casting(
    renderers: dict[str, Renderer], kind: str, focal: tuple[float, float, float, float]
):
    """Half a pixel of shift would change more than 50 pixels of the mask."""
    view = default_camera()
    camera = Camera(640, 480, *focal, view.position, view.orientation)
    block = block_from_attributes(DOMAIN, {"color": "red", "size": "small"})
    poses = [Pose.upright(0.45, -0.1, 0.02, 0.3), Pose.upright(0.55, 0.15, 0.02, -0.1)]
    with World(robot=False) as world:
        world.spawn([block, block], poses)
        frame = get(renderers, kind).render(world, camera, Light())
    for number, pose in enumerate(poses, start=1):
        expected = cast(camera, pose, block.edges_m)
        hit = frame.mask == number
        assert np.count_nonzero(hit != np.isfinite(expected)) <= 3
        both = hit & np.isfinite(expected)
        assert np.count_nonzero(both) > 1000
        assert np.abs(frame.depth[both] - expected[both]).max() < 2e-5
    # The table, where nothing stands on it.
    bare = (frame.mask == 0) & (np.arange(480)[:, None] > 150)
    rows, columns = np.nonzero(bare)
    pixels = np.stack([columns + 0.5, rows + 0.5, frame.depth[bare]], axis=-1)
    assert np.abs(camera.back_project(pixels)[:, 2]).max() < 2e-5


@pytest.mark.parametrize("seed", range(8))
def test_both_renderers_show_the_same(renderers: dict[str, Renderer], seed: int):
    camera = default_camera()
    light = Light.sample(np.random.default_rng(seed))
    with World() as world:
        build_scene(world, seed, tower=3 * (seed % 2))
        a = get(renderers, "gl").render(world, camera, light)
        b = get(renderers, "pybullet").render(world, camera, light)
        alone = [get(renderers, kind).surfaces(world, camera) for kind in KINDS]
    for surfaces, frame in zip(alone, (a, b), strict=True):
        assert np.array_equal(surfaces.mask, frame.mask)
        assert np.array_equal(surfaces.depth, frame.depth)
    seen, other = segmented_image(a), segmented_image(b)
    assert seen.ids == other.ids and len(seen.ids) >= 4
    boxes = np.rint(seen.boxes * [640, 480, 640, 480]).astype(int)
    others = np.rint(other.boxes * [640, 480, 640, 480]).astype(int)
    assert np.abs(boxes - others).max() <= 1
    assert np.abs(seen.depths - other.depths).max() < 1e-4
    assert np.abs(a.depth - b.depth)[(a.mask == 0) & (b.mask == 0)][100 * 640 :].max() < 1e-4
    for x1, y1, x2, y2 in boxes:
        crop, same = (f.rgb[y1:y2, x1:x2].astype(float) for f in (a, b))
        assert np.abs(crop.mean(axis=(0, 1)) - same.mean(axis=(0, 1))).max() < 3
        # The samples within a pixel differ: only edges do, by up to half a step.
        assert np.abs(crop - same).mean() < 8


@pytest.mark.parametrize("kind", KINDS)
def test_the_light_model_is_the_documented_one(renderers: dict[str, Renderer], kind: str):
    light = Light(direction=(0.6, 0.0, 0.8), ambient=0.3, diffuse=0.5, color=(1.0, 0.9, 0.8))
    block = block_from_attributes(DOMAIN, {"color": "yellow", "size": "small"})
    camera = default_camera()
    with World(robot=False) as world:
        world.spawn([block], [Pose((0.5, 0.0, 0.02))])
        frame = get(renderers, kind).render(world, camera, light)
    for point, normal in (((0.5, 0.0, 0.04), (0, 0, 1)), ((0.52, 0.0, 0.02), (1, 0, 0))):
        u, v, _ = camera.project(point)
        expected = 255 * np.array(block.rgb) * light.shade(normal)
        got = frame.rgb[int(v), int(u)].astype(float)
        assert np.abs(got - expected).max() <= 2.5


@pytest.mark.parametrize("kind", KINDS)
def test_studs_and_shadows_are_visible(renderers: dict[str, Renderer], kind: str):
    lego = block_from_attributes(DOMAIN, {"color": "green", "size": "lego"})
    camera = default_camera()
    with World(robot=False) as world:
        world.spawn([lego], [Pose((0.5, 0.0, 0.025))])
        frame = get(renderers, kind).render(world, camera, Light())
    # On top: the plain face and the studs' dark sides; a cube's top has one shade.
    u0, v0, _ = camera.project((0.475, -0.025, 0.046))
    u1, v1, _ = camera.project((0.525, 0.025, 0.046))
    top = frame.rgb[int(v0) + 1 : int(v1), int(u0) + 1 : int(u1), 1].astype(float)
    assert np.mean(top < 0.85 * np.median(top)) > 0.02
    # The lamp is at -y: the shadow falls to +y.
    shaded, lit = (camera.project((0.47, y, 0.0)) for y in (0.038, -0.045))
    assert frame.rgb[int(shaded[1]), int(shaded[0])].sum() < (
        0.8 * frame.rgb[int(lit[1]), int(lit[0])].sum()
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_robot_hides_nothing_of_the_work_space(renderers: dict[str, Renderer], kind: str):
    block = block_from_attributes(DOMAIN, {"color": "red", "size": "lego"})
    x0, y0, _ = WORK_SPACE.min
    x1, y1, top = WORK_SPACE.max
    poses = [Pose((x, y, top)) for x in (x0, x1) for y in (y0, 0.0, y1)]
    masks, pictures = [], []
    for robot in (True, False):
        with World(robot=robot) as world:
            world.spawn([block] * len(poses), poses)
            frame = get(renderers, kind).render(world, default_camera(), Light())
            masks.append(frame.mask)
            pictures.append(frame.rgb)
    np.testing.assert_array_equal(*masks)
    assert np.abs(pictures[0].astype(int) - pictures[1]).max() > 50, "but it is in the picture"


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_pictures_do_not_depend_on_what_was_drawn_before(renderers: dict[str, Renderer], kind: str):
    renderer = get(renderers, kind)
    bright = Light(ambient=0.7, diffuse=0.2)
    with World() as world:
        build_scene(world, 5)
        first = renderer.render(world, default_camera(), Light())
        build_scene(world, 6)
        renderer.render(world, default_camera(), bright)
        renderer.render(world, default_camera().scaled(2), Light())
        build_scene(world, 5)
        again = renderer.render(world, default_camera(), Light())
    for name in ("rgb", "depth", "mask"):
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))


def picture_digest(kind: str) -> str:
    renderer = open_renderer(kind)
    with World() as world:
        build_scene(world, 4)
        seen = render_segmented(renderer, world, default_camera(), Light())
    renderer.close()
    parts = (seen.rgb, seen.depth, seen.boxes, seen.depths)
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


@pytest.mark.parametrize("kind", KINDS)
def test_pictures_are_the_same_bytes_in_another_process(kind: str):
    if kind == "gl":
        require_gl().close()
    other = elsewhere(f"import test_render as t; print(t.picture_digest({kind!r}))")
    assert other == picture_digest(kind)


def test_the_environment_overrides_auto(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(VARIABLE, "pybullet")
    renderer = open_renderer("auto")
    assert renderer.name == "pybullet" and "TinyRenderer" in renderer.description
    renderer.close()
    monkeypatch.setenv(VARIABLE, "canvas")
    with pytest.raises(RendererError, match=f"{VARIABLE}='canvas'.*gl, pybullet"):
        open_renderer("auto")


def test_an_unknown_kind_is_refused():
    with pytest.raises(RendererError, match="'vulkan'"):
        open_renderer("vulkan")


def test_without_egl_auto_falls_back_and_gl_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.delenv(VARIABLE, raising=False)
    code = (
        "from nsrm_harness.simulation.render import open_renderer, RendererError\n"
        "print(open_renderer('auto').name)\n"
        "try: open_renderer('gl')\n"
        "except RendererError as error: print(error)\n"
    )
    lines = elsewhere(code, GLCONTEXT_LINUX_LIBEGL="libnothing.so").splitlines()
    assert lines[0] == "pybullet"
    assert "libegl1" in lines[1] and "libnothing.so" in lines[1]


def test_sampled_lights_vary_and_repeat():
    lights = [Light.sample(np.random.default_rng(seed)) for seed in range(200)]
    assert lights[3] == Light.sample(np.random.default_rng(3))
    assert len({light.direction for light in lights}) == 200
    for light in lights:
        assert np.linalg.norm(light.direction) == pytest.approx(1)
        assert light.direction[2] > 0.7
        assert 0.7 < max(light.shade((0.0, 0.0, 1.0))) < 1.25
