"""Fixtures that several test files share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from nsrm_harness.simulation.render import Renderer, open_renderer
from nsrm_harness.simulation.world import World


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    drawing = open_renderer()
    yield drawing
    drawing.close()


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    with World() as made:
        yield made
