"""Renders images of a world: colour, depth and block ids, with one interface.

Two renderers draw the same scene (`scene`) with the same light model: OpenGL (`gl`, fast, needs
libEGL) and PyBullet's own (`tiny`, no dependencies).
"""

from __future__ import annotations

import os
from typing import Literal, Protocol

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.simulation.render.frame import Frame, Surfaces
from nsrm_harness.simulation.render.light import Light
from nsrm_harness.simulation.world import World

Kind = Literal["auto", "gl", "pybullet"]
KINDS: tuple[Kind, ...] = ("auto", "gl", "pybullet")
VARIABLE = "NSRM_RENDERER"
"""Environment variable that overrides "auto"."""

__all__ = [
    "KINDS",
    "VARIABLE",
    "Frame",
    "Light",
    "Renderer",
    "RendererError",
    "Surfaces",
    "open_renderer",
]


class RendererError(HarnessError):
    """The requested renderer cannot run here."""


class Renderer(Protocol):
    """Renders worlds. The same calls give the same bytes on the same machine."""

    @property
    def name(self) -> str:
        """ "gl" or "pybullet"."""
        ...

    @property
    def description(self) -> str:
        """Name and version of the rendering library, for records."""
        ...

    def render(self, world: World, camera: Camera, light: Light) -> Frame:
        """Renders the current world."""
        ...

    def surfaces(self, world: World, camera: Camera) -> Surfaces:
        """Renders the same image without colours, with less than half of the work."""
        ...

    def close(self) -> None:
        """Frees its resources; it must not be used afterwards."""
        ...


def open_renderer(kind: str = "auto") -> Renderer:
    """Opens a renderer: "gl", "pybullet", or "auto".

    "auto" is the one named by the environment variable `NSRM_RENDERER`, otherwise OpenGL if a
    context can be created, otherwise PyBullet's. Raises `RendererError` for an unknown kind, and if
    OpenGL is requested by name but cannot run.
    """
    chosen = kind
    if kind == "auto":
        chosen = os.environ.get(VARIABLE, "").strip() or "auto"
    if chosen not in KINDS:
        where = f"{VARIABLE}={chosen!r}" if chosen != kind else f"renderer {chosen!r}"
        raise RendererError(f"{where}: unknown, expected one of {', '.join(KINDS)}")
    from nsrm_harness.simulation.render import gl, tiny

    if chosen == "pybullet":
        return tiny.TinyRenderer()
    try:
        return gl.GlRenderer()
    except gl.GlUnavailableError as error:
        if chosen == "gl":
            raise RendererError(
                f"the OpenGL renderer cannot run here: {error}. Install libegl1 and "
                f"libgl1-mesa-dri, or use the renderer 'pybullet'"
            ) from error
        return tiny.TinyRenderer()
