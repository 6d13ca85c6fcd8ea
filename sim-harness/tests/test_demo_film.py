"""The demonstration shows everything that was filmed, whatever the outcome."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from PIL import Image

from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render import Renderer
from nsrm_harness.visualization.film import FRAME_S, Film

FRAMES = 3


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    with closing(ArmWorld()) as made:
        yield made


def filmed(world: ArmWorld, renderer: Renderer) -> Film:
    film = Film(world, renderer, small=True)
    for _ in range(round(2 * FRAMES * FRAME_S / world.tick_s)):
        world.tick()
    return film


def test_an_arm_that_only_waits_has_a_film_and_a_picture(
    world: ArmWorld, renderer: Renderer, tmp_path: Path
) -> None:
    film, strip = filmed(world, renderer).save(tmp_path)
    with Image.open(film) as shown:
        width, height = shown.size
    with Image.open(strip) as shown:
        assert width < shown.width < 2 * width and height < shown.height < 2 * height


def test_each_event_that_is_shown_has_a_picture(
    world: ArmWorld, renderer: Renderer, tmp_path: Path
) -> None:
    film = filmed(world, renderer)
    for event in ("reached", "grasped", "above", "lifted"):
        film.mark(event)
    path, strip = film.save(tmp_path)
    with Image.open(path) as shown, Image.open(strip) as pictures:
        assert 2 * shown.width < pictures.width < 3 * shown.width


def test_an_arm_that_never_began_has_a_picture_too(
    world: ArmWorld, renderer: Renderer, tmp_path: Path
) -> None:
    film, strip = Film(world, renderer).save(tmp_path)
    with Image.open(film) as shown, Image.open(strip) as picture:
        assert getattr(shown, "n_frames", 1) == 1
        assert picture.width > shown.width and picture.height > shown.height
