"""Pictures of a world: colour, depth and block ids, behind one interface.

Two renderers draw the same scene (`scene`) under the same light model: OpenGL
(`gl`, fast, needs libEGL) and PyBullet's own (`tiny`, needs nothing).
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
    """No renderer of the kind asked for can run here."""


class Renderer(Protocol):
    """Draws worlds. The same calls give the same bytes on the same machine."""

    @property
    def name(self) -> str:
        """ "gl" or "pybullet"."""
        ...

    @property
    def description(self) -> str:
        """What draws, with its version, for the record."""
        ...

    def render(self, world: World, camera: Camera, light: Light) -> Frame:
        """A picture of the world as it stands now."""
        ...

    def surfaces(self, world: World, camera: Camera) -> Surfaces:
        """The same picture without its colours, for less than half of the work."""
        ...

    def close(self) -> None:
        """Frees what it holds; it must not be used afterwards."""
        ...


def open_renderer(kind: str = "auto") -> Renderer:
    """The renderer of that kind: "gl", "pybullet", or "auto".

    "auto" is what the environment variable `NSRM_RENDERER` names, else OpenGL where
    a context can be made, else PyBullet's. Raises `RendererError` for an unknown
    kind and where OpenGL was asked for by name and cannot run.
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
