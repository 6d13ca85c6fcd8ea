"""Films the arm, as a GIF and as a strip of images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.visualization.pictures import in_rows

FRAME_S = 0.12
"""Simulated time between two frames."""
SPEED = 1.5
"""Speed of the film relative to simulated time."""
SMALL = 2 / 3
"""Side lengths of a small film, relative to a normal one."""
COLORS = 192
PALETTE_FRAMES = 8
"""Number of colours of the film, and of frames from which they are taken."""
COLUMNS = 4
"""Columns of the strip: an undisturbed step fills one row."""
SHOWN = ("grasped", "above", "let go", "home", "not grasped", "slipped")
"""The events shown in the strip."""
LAST = "in the end"
"""Title of the only image if no such event happened: the arm waited, stopped, or did nothing."""


class Film:
    """Films an arm from its side while it works.

    * `small`: half as many frames with less than half the pixels, for many films
    """

    def __init__(self, world: ArmWorld, renderer: Renderer, *, small: bool = False) -> None:
        self._world, self._renderer = world, renderer
        scale = SMALL if small else 1.0
        self._camera = Camera.looking_at(
            (1.10, -0.75, 0.80),
            (0.46, 0.0, 0.15),
            width=round(480 * scale),
            height=round(360 * scale),
            focal_px=580.0 * scale,
        )
        self._frame_s = 2 * FRAME_S if small else FRAME_S
        self._ticks = 0
        self._frames: list[NDArray[np.uint8]] = []
        self._shots: list[tuple[str, NDArray[np.uint8]]] = []
        self._others_tick = world.on_tick
        world.on_tick = self._tick

    def _tick(self) -> None:
        self._others_tick()
        if self._ticks % round(self._frame_s / self._world.tick_s) == 0:
            self._frames.append(self._look())
        self._ticks += 1

    def mark(self, event: str) -> None:
        """Takes an image for the strip."""
        if event in SHOWN:
            self._shots.append((event, self._look()))

    def save(self, folder: Path) -> list[Path]:
        """Writes `film.gif` and `strip.png`, with one image each if nothing was done."""
        film, strip = folder / "film.gif", folder / "strip.png"
        last = self._look()
        filmed = [*self._frames, last]
        # One palette for all frames, so that static parts keep their colours.
        some = filmed[:: max(1, len(filmed) // PALETTE_FRAMES)]
        palette = Image.fromarray(np.vstack(some)).quantize(COLORS)
        frames = [
            Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
            for frame in filmed
        ]
        pause = [round(1000 * self._frame_s / SPEED)] * (len(frames) - 1) + [1500]
        frames[0].save(film, save_all=True, append_images=frames[1:], duration=pause, loop=0)
        titles, pictures = zip(*(self._shots or [(LAST, last)]), strict=True)
        in_rows(pictures, titles, COLUMNS).save(strip)
        return [film, strip]

    def _look(self) -> NDArray[np.uint8]:
        return self._renderer.render(self._world, self._camera, Light()).rgb
