"""Scenes for the tests of the world, each from its seed."""

from __future__ import annotations

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block, block_from_attributes
from nsrm_harness.simulation.layout import sample_layout
from nsrm_harness.simulation.render import VARIABLE, Renderer, RendererError, open_renderer
from nsrm_harness.simulation.world import World

DOMAIN = domains.load()


def random_blocks(rng: np.random.Generator, count: int) -> list[Block]:
    return [
        block_from_attributes(
            DOMAIN,
            {
                attribute.name: attribute.values[int(rng.integers(len(attribute.values)))].name
                for attribute in DOMAIN.attributes
            },
        )
        for _ in range(count)
    ]


def on_top(world: World, moved: int, reference: int) -> Pose:
    """Where `moved` belongs when it stands centred on `reference`."""
    blocks = {placed.id: placed.block for placed in world.placed()}
    x, y, z = world.pose(reference).position
    return Pose((x, y, z + (blocks[reference].edges_m[2] + blocks[moved].edges_m[2]) / 2))


def build_scene(world: World, seed: int, *, tower: int = 0) -> None:
    """4 to 6 blocks at rest; `tower` of them put on block 1, one after the other."""
    rng = np.random.default_rng(seed)
    blocks = random_blocks(rng, int(rng.integers(4, 7)))
    world.reset()
    world.spawn(blocks, sample_layout(rng, blocks))
    assert world.settle().at_rest, f"seed {seed}"
    for moved in range(2, 2 + tower):
        world.place(moved, on_top(world, moved, moved - 1))
        assert world.settle().at_rest, f"seed {seed}, block {moved}"


def require_gl() -> Renderer:
    """The OpenGL renderer; without EGL the test fails, unless it was ruled out."""
    import os

    if os.environ.get(VARIABLE) == "pybullet":
        pytest.skip(f"{VARIABLE}=pybullet: the OpenGL renderer is NOT tested")
    try:
        return open_renderer("gl")
    except RendererError as error:
        pytest.fail(f"{error}; or set {VARIABLE}=pybullet to run the tests without it")
