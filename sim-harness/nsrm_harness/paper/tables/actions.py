"""Draws what each action has learned from final scenes: where the core's action module puts a block
relative to each reference on a grid."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import nsrm
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from numpy.typing import NDArray

from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block, block_from_attributes
from nsrm_harness.simulation.layout import WORK_SPACE
from nsrm_harness.simulation.render import Renderer, open_renderer
from nsrm_harness.simulation.segmentation import render_objects
from nsrm_harness.simulation.world import World

ROWS, COLUMNS = 5, 7
MARGIN_M = 0.03
START_M = (0.40, 0.0)
"""Where the moved block stands at first; x, y in the world."""


def draw_actions(model: nsrm.Model, domain: Domain, path: Path) -> None:
    """Draws a panel for each action, the table seen from above, as a PNG."""
    moved, reference = (
        block_from_attributes(domain, {a.name: a.values[pick].name for a in domain.attributes})
        for pick in (-1, 0)
    )
    renderer = open_renderer()
    try:
        with World() as world:
            start = _seen(world, renderer, moved, START_M)
            places = [_seen(world, renderer, reference, at) for at in _grid()]
    finally:
        renderer.close()
    camera = nsrm.Camera(**asdict(default_camera()))
    standing = np.array([model.locate(place, camera) for place in places])
    figure, axes = plt.subplots(
        1,
        len(domain.actions),
        figsize=(4.6 * len(domain.actions), 3.4),
        layout="constrained",
        squeeze=False,
        sharey=True,
    )
    for axis, action in zip(axes[0], domain.actions, strict=True):
        ends = [model.simulate(action.name, start, place) for place in places]
        placed = np.array([model.locate(end, camera) for end in ends])
        points = _draw(axis, action.name, standing, placed)
    axes[0, 0].set_ylabel("x, metres")
    axes[0, 0].invert_yaxis()
    figure.colorbar(points, ax=axes[0], label="height of the centre, mm", shrink=0.8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _grid() -> list[tuple[float, float]]:
    (x0, y0, _), (x1, y1, _) = WORK_SPACE.min, WORK_SPACE.max
    return [
        (float(x), float(y))
        for x in np.linspace(x0 + MARGIN_M, x1 - MARGIN_M, ROWS)
        for y in np.linspace(y0 + MARGIN_M, y1 - MARGIN_M, COLUMNS)
    ]


def _seen(
    world: World, renderer: Renderer, block: Block, at: tuple[float, float]
) -> NDArray[np.float32]:
    """Box and depth `[5]` of a single block."""
    world.reset()
    world.spawn([block], [Pose.upright(*at, block.edges_m[2] / 2)])
    return render_objects(renderer, world, default_camera()).location(1)


def _draw(
    axis: Axes, name: str, standing: NDArray[np.float32], placed: NDArray[np.float32]
) -> PathCollection:
    """Draws the camera's view: the world's y points right, its x (towards the camera) down."""
    shift = placed - standing
    axis.plot(standing[:, 1], standing[:, 0], "s", ms=7, color="0.8")
    axis.quiver(
        standing[:, 1],
        standing[:, 0],
        shift[:, 1],
        shift[:, 0],
        angles="xy",
        scale_units="xy",
        scale=1,
        width=0.004,
        color="tab:blue",
    )
    x, y, z = shift.mean(axis=0) * 1e3
    dx, dy, dz = shift.std(axis=0) * 1e3
    axis.set_title(
        f"{name}\nx {x:+.1f} ± {dx:.1f}, y {y:+.1f} ± {dy:.1f}, z {z:+.1f} ± {dz:.1f} mm",
        fontsize=10,
    )
    axis.set(xlabel="y, metres", aspect="equal", xlim=(-0.34, 0.34))
    axis.grid(alpha=0.3)
    return axis.scatter(
        placed[:, 1], placed[:, 0], c=placed[:, 2] * 1e3, s=22, vmin=0, vmax=90, zorder=3
    )
