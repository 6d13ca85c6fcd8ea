"""Renders with OpenGL without a window: moderngl on EGL, in software if there is no GPU.

It uses two passes: colour with 4 samples per pixel, then id and depth at the pixel centres.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import Camera, linear_depth
from nsrm_harness.geometry.mesh import Mesh
from nsrm_harness.simulation.blocks import block_mesh
from nsrm_harness.simulation.render.frame import Frame, Surfaces
from nsrm_harness.simulation.render.light import Light
from nsrm_harness.simulation.render.scene import RenderPart, robot_parts, shadow_parts, surroundings
from nsrm_harness.simulation.world import World

SAMPLES = 4
MAX_MESHES = 256
"""Largest number of meshes kept on the GPU; the least recently drawn are dropped first."""

_LIBRARY = "libEGL.so.1"

_VERTEX = """
#version 330
uniform mat4 clip_from_world;
uniform mat4 world_from_body;
in vec3 position;
in vec3 normal;
out vec3 world_normal;
void main() {
    gl_Position = clip_from_world * world_from_body * vec4(position, 1.0);
    world_normal = mat3(world_from_body) * normal;
}
"""

_COLOR = """
#version 330
uniform vec3 surface;
uniform vec3 direction;
uniform float ambient;
uniform vec3 diffuse;
in vec3 world_normal;
out vec4 color;
void main() {
    float facing = max(0.0, dot(normalize(world_normal), direction));
    color = vec4(surface * (ambient + diffuse * facing), 1.0);
}
"""

_ID = """
#version 330
uniform int id;
in vec3 world_normal;
out int block;
void main() { block = id; }
"""


class GlUnavailableError(Exception):
    """No OpenGL 3.3 context without a window can be created on this machine."""


@lru_cache(maxsize=1)
def _context() -> Any:
    """The only context of this process: two would corrupt each other."""
    import moderngl

    # By file name, which needs no ldconfig; and libEGL instead of libGL, which is another package:
    # all functions come from eglGetProcAddress.
    settings: dict[str, Any] = {"backend": "egl", "libegl": _LIBRARY, "libgl": _LIBRARY}
    try:
        return moderngl.create_context(require=330, standalone=True, **settings)
    # The backend loads libraries itself and raises arbitrary exceptions.
    except Exception as error:
        raise GlUnavailableError(str(error) or type(error).__name__) from error


class _Targets:
    """Framebuffers for one image size."""

    def __init__(self, context: Any, width: int, height: int) -> None:
        size = (width, height)
        self.multisampled = context.framebuffer(
            [context.renderbuffer(size, 4, samples=SAMPLES)],
            context.depth_renderbuffer(size, samples=SAMPLES),
        )
        self.color = context.framebuffer([context.renderbuffer(size, 4)])
        self.depth_texture = context.depth_texture(size)
        self.ids = context.framebuffer([context.texture(size, 1, dtype="i4")], self.depth_texture)


class GlRenderer:
    """The fast renderer. Raises `GlUnavailableError` if it cannot run."""

    name = "gl"

    def __init__(self) -> None:
        self._gl = _context()
        self._color = self._gl.program(vertex_shader=_VERTEX, fragment_shader=_COLOR)
        self._id = self._gl.program(vertex_shader=_VERTEX, fragment_shader=_ID)
        self._targets: dict[tuple[int, int], _Targets] = {}
        self._meshes: dict[Mesh, tuple[Any, ...]] = {}

    @property
    def description(self) -> str:
        """The driver's description."""
        info = self._gl.info
        return f"{info['GL_RENDERER']}, OpenGL {info['GL_VERSION']}"

    def render(self, world: World, camera: Camera, light: Light) -> Frame:
        """Renders the current world."""
        targets, clip_from_world = self._aim(camera)
        shadows = list(shadow_parts(world.placed(), light))
        standing, behind = _parts(world, camera)
        targets.multisampled.use()
        targets.multisampled.clear(0.0, 0.0, 0.0, 1.0)
        self._color["clip_from_world"].write(clip_from_world)
        self._color["direction"].value = light.direction
        self._color["ambient"].value = light.ambient
        self._color["diffuse"].value = tuple(light.diffuse * c for c in light.color)
        self._draw_color(part for part, _ in standing)
        self._draw_color(shadows)
        self._draw_color(part for part, _ in behind)
        for part in shadows:
            self._forget(part.mesh)
        self._gl.copy_framebuffer(targets.color, targets.multisampled)
        rgb = np.frombuffer(targets.color.read(components=3, alignment=1), np.uint8)
        rgb = np.ascontiguousarray(rgb.reshape(camera.height, camera.width, 3)[::-1])
        seen = self.surfaces(world, camera)
        return Frame(seen.depth, seen.mask, rgb)

    def surfaces(self, world: World, camera: Camera) -> Surfaces:
        """Renders the same image without colours: only the second pass."""
        targets, clip_from_world = self._aim(camera)
        standing, behind = _parts(world, camera)
        targets.ids.use()
        targets.ids.clear(depth=1.0)
        self._id["clip_from_world"].write(clip_from_world)
        self._draw_ids(standing + behind)
        mask = np.frombuffer(targets.ids.read(components=1, dtype="i4"), np.int32)
        depth = np.frombuffer(targets.depth_texture.read(alignment=4), np.float32)
        shape = (camera.height, camera.width)
        return Surfaces(
            linear_depth(np.ascontiguousarray(depth.reshape(shape)[::-1])),
            np.ascontiguousarray(mask.reshape(shape)[::-1]),
        )

    def _aim(self, camera: Camera) -> tuple[_Targets, bytes]:
        """The framebuffers for the camera's image size, and its matrix."""
        size = (camera.width, camera.height)
        if size not in self._targets:
            self._targets[size] = _Targets(self._gl, *size)
        self._gl.enable_only(self._gl.DEPTH_TEST | self._gl.CULL_FACE)
        return self._targets[size], _columns(camera.projection_matrix() @ camera.view_matrix())

    def close(self) -> None:
        """Frees framebuffers and meshes; the process's context stays."""
        for targets in self._targets.values():
            for buffer in (targets.multisampled, targets.color, targets.ids):
                buffer.release()
        self._targets.clear()
        for mesh in list(self._meshes):
            self._forget(mesh)

    def _draw_color(self, parts: Iterable[RenderPart]) -> None:
        for part in parts:
            self._color["world_from_body"].write(_columns(part.pose.matrix()))
            self._color["surface"].value = part.mesh.rgb
            self._arrays(part.mesh)[0].render()

    def _draw_ids(self, parts: Iterable[tuple[RenderPart, int]]) -> None:
        for part, block_id in parts:
            self._id["world_from_body"].write(_columns(part.pose.matrix()))
            self._id["id"].value = block_id
            self._arrays(part.mesh)[1].render()

    def _forget(self, mesh: Mesh) -> None:
        for resource in self._meshes.pop(mesh):
            resource.release()

    def _arrays(self, mesh: Mesh) -> tuple[Any, ...]:
        if mesh in self._meshes:
            # Move to the end: the order is that of last use.
            self._meshes[mesh] = self._meshes.pop(mesh)
        else:
            while len(self._meshes) >= MAX_MESHES:
                self._forget(next(iter(self._meshes)))
            data = self._gl.buffer(
                np.hstack([mesh.vertices, mesh.normals]).astype(np.float32).tobytes()
            )
            index = self._gl.buffer(mesh.triangles.astype(np.int32).tobytes())
            self._meshes[mesh] = (
                self._gl.vertex_array(self._color, [(data, "3f 3f", "position", "normal")], index),
                self._gl.vertex_array(self._id, [(data, "3f 3x4", "position")], index),
                data,
                index,
            )
        return self._meshes[mesh]


def _parts(
    world: World, camera: Camera
) -> tuple[list[tuple[RenderPart, int]], list[tuple[RenderPart, int]]]:
    """Blocks and robot, then the surroundings, each with its id: front to back, so that the large
    faces fill only the rest."""
    standing = [(RenderPart(block_mesh(b.block), b.pose), b.id) for b in world.placed()]
    standing += [(part, 0) for part in robot_parts(world.arm_links(), camera)]
    return standing, [(part, 0) for part in surroundings()]


def _columns(matrix: NDArray[np.float64]) -> bytes:
    """A matrix in OpenGL's order: column by column, single precision."""
    return matrix.T.astype(np.float32).tobytes()
