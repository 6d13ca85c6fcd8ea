"""Renders with PyBullet's software renderer: slow, but without system libraries.

It draws the same meshes as `gl`, in a client without physics, over a computed backdrop. Colour is
drawn with `OVERSAMPLING` times as many pixels per side and averaged; id and depth are drawn at the
image's size, without shadows.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import Camera, linear_depth
from nsrm_harness.geometry.mesh import Mesh
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_mesh
from nsrm_harness.simulation.bullet import connect_direct, pybullet
from nsrm_harness.simulation.render.backdrop import backdrop
from nsrm_harness.simulation.render.frame import Frame, Surfaces
from nsrm_harness.simulation.render.light import Light
from nsrm_harness.simulation.render.scene import RenderPart, robot_parts, shadow_parts
from nsrm_harness.simulation.world import PlacedBlock, World

OVERSAMPLING = 2
MAX_MESHES = 256
"""Largest number of meshes with bodies; beyond it, those not in the image are dropped."""

SAMPLE_SHIFT_PX = (-0.5, 0.5)
"""TinyRenderer samples (i, j + 1) for pixel (i, j), a camera (i + ½, j + ½): the principal point is
shifted so that both rays are equal."""

_AWAY = Pose((0.0, 0.0, -1000.0))
"""Where bodies are kept that are not in the image."""


class TinyRenderer:
    """The renderer that works everywhere."""

    name = "pybullet"

    def __init__(self) -> None:
        self._client = connect_direct()
        self._shapes: dict[Mesh, int] = {}
        self._bodies: dict[Mesh, list[int]] = defaultdict(list)

    @property
    def description(self) -> str:
        """Library and version."""
        return f"PyBullet TinyRenderer, API {pybullet.getAPIVersion()}"

    def render(self, world: World, camera: Camera, light: Light) -> Frame:
        """Renders the current world."""
        # Before the colours, because it arranges the bodies.
        seen = self.surfaces(world, camera)
        return Frame(seen.depth, seen.mask, self._colors(world.placed(), camera, light))

    def surfaces(self, world: World, camera: Camera) -> Surfaces:
        """Renders the same image without colours."""
        solid = [(part, 0) for part in robot_parts(world.arm_links(), camera)]
        solid += [(RenderPart(block_mesh(b.block), b.pose), b.id) for b in world.placed()]
        id_of_body = self._arrange(solid)
        _, buffer, bodies = self._shoot(camera, Light())
        # PyBullet numbers bodies from 0; -1, the last entry, means none.
        ids = np.zeros(max(id_of_body, default=-1) + 2, dtype=np.int32)
        for body, block_id in id_of_body.items():
            ids[body] = block_id
        depth = np.where(bodies >= 0, linear_depth(buffer), backdrop(camera).depth)
        return Surfaces(depth, ids[bodies])

    def close(self) -> None:
        """Closes the client."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    def _colors(
        self, blocks: Sequence[PlacedBlock], camera: Camera, light: Light
    ) -> NDArray[np.uint8]:
        """The image `[H, W, 3]` of the bodies, with the blocks' shadows."""
        fine = camera.scaled(OVERSAMPLING)
        shadows = [self._body(part) for part in shadow_parts(blocks, light)]
        drawn, _, bodies = self._shoot(fine, light)
        for body in shadows:
            pybullet.removeBody(body, physicsClientId=self._client)
        samples = np.where((bodies < 0)[..., None], backdrop(fine).rgb(light), drawn)
        count = OVERSAMPLING * OVERSAMPLING
        total = np.full((camera.height, camera.width, 3), count // 2, dtype=np.uint16)
        for row in range(OVERSAMPLING):
            for column in range(OVERSAMPLING):
                total += samples[row::OVERSAMPLING, column::OVERSAMPLING]
        return (total // count).astype(np.uint8)

    def _arrange(self, parts: Iterable[tuple[RenderPart, int]]) -> dict[int, int]:
        """Puts a body at each part and hides all others; returns the block id of each body."""
        free = {mesh: list(bodies) for mesh, bodies in self._bodies.items()}
        id_of_body: dict[int, int] = {}
        for part, block_id in parts:
            if free.get(part.mesh):
                body = free[part.mesh].pop(0)
                self._move(body, part.pose)
            else:
                body = self._body(part)
                self._bodies[part.mesh].append(body)
            id_of_body[body] = block_id
        too_many = len(self._bodies) > MAX_MESHES
        for mesh, bodies in free.items():
            for body in bodies:
                if too_many:
                    self._bodies[mesh].remove(body)
                    pybullet.removeBody(body, physicsClientId=self._client)
                else:
                    self._move(body, _AWAY)
                    id_of_body[body] = 0
            if not self._bodies[mesh]:
                del self._bodies[mesh]
        return id_of_body

    def _move(self, body: int, pose: Pose) -> None:
        pybullet.resetBasePositionAndOrientation(
            body, pose.position, pose.orientation, physicsClientId=self._client
        )

    def _body(self, part: RenderPart) -> int:
        mesh = part.mesh
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=mesh.vertices.tolist(),
            indices=mesh.triangles.ravel().tolist(),
            normals=mesh.normals.tolist(),
            rgbaColor=[*mesh.rgb, 1.0],
            physicsClientId=self._client,
        )
        if shape < 0:
            raise RuntimeError(f"PyBullet rejected a mesh with {len(mesh.vertices)} vertices")
        return pybullet.createMultiBody(
            baseMass=0,
            baseVisualShapeIndex=shape,
            basePosition=part.pose.position,
            baseOrientation=part.pose.orientation,
            physicsClientId=self._client,
        )

    def _shoot(
        self, camera: Camera, light: Light
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int32]]:
        """Colour `[H, W, 3]`, depth buffer `[H, W]` and body of each pixel `[H, W]`,
        -1 for none."""
        width, height = camera.width, camera.height
        _, _, color, depth, bodies = pybullet.getCameraImage(
            width,
            height,
            viewMatrix=camera.view_matrix().T.ravel().tolist(),
            projectionMatrix=camera.projection_matrix(SAMPLE_SHIFT_PX).T.ravel().tolist(),
            lightDirection=light.direction,
            lightColor=light.color,
            lightAmbientCoeff=light.ambient,
            lightDiffuseCoeff=light.diffuse,
            lightSpecularCoeff=0.0,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        return (
            np.asarray(color, dtype=np.uint8).reshape(height, width, 4)[:, :, :3],
            np.asarray(depth, dtype=np.float32).reshape(height, width),
            np.asarray(bodies, dtype=np.int32).reshape(height, width),
        )
