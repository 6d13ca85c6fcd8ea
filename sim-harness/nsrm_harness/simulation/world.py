"""The physics of the tabletop: blocks are put down, fall, and come to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike

from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.simulation import arm
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.bullet import connect_direct, pybullet

TIME_STEP_S = 1.0 / 1000.0
SOLVER_ITERATIONS = 50
FRICTION = 0.6
"""Friction of each surface. Bullet multiplies the values of two surfaces: 0.36 between blocks and
on the table, as for dry wood on wood (docs/arm)."""
BLOCK_DENSITY_KG_M3 = 700.0
"""Density of beech (docs/arm)."""
CONTACT_BREAKING_M = 0.02
"""PyBullet's default. It is global to the process and outlives clients: another client may have
changed it, so it is set again before every call that moves a block (even setting a position makes
contacts)."""

DROP_M = 0.003
"""Height above its goal from which a block is released."""

REST_SPEED_M_S = 1e-3
REST_TURN_RAD_S = 1e-2
REST_STEPS = 12
"""A block is at rest if it stays below both speeds for this many steps."""
MAX_STEPS = 3000

TABLE_LOW: Vector3 = (-0.20, -0.70, -0.04)
TABLE_HIGH: Vector3 = (1.00, 0.70, 0.0)
"""The table: a slab with its top face at z = 0."""

GRAVITY_M_S2 = 9.81


@dataclass(frozen=True)
class Settled:
    """The result of settling: whether all blocks came to rest, and the number of steps."""

    at_rest: bool
    steps: int


@dataclass(frozen=True)
class PlacedBlock:
    """A block in the world; ids count from 1."""

    id: int
    block: Block
    pose: Pose


class World:
    """A table, a Panda at rest and blocks, in a separate PyBullet client.

    The arm stands still, above and behind the workspace, where no block can touch it: it is
    visible, but not part of the blocks' physics.

    A context manager. Time is counted in steps and nothing is random, so the same calls give the
    same poses, bit by bit, in any process and after any history.
    """

    def __init__(self, *, robot: bool = True) -> None:
        self._client = connect_direct()
        self._blocks: dict[int, Block] = {}
        self._bodies: dict[int, int] = {}
        self._links = dict(arm.rest_links()) if robot else {}
        self._steps = 0
        self._build()

    def __enter__(self) -> World:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Closes the client; the world must not be used afterwards."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    def spawn(self, blocks: Sequence[Block], poses: Sequence[Pose]) -> None:
        """Adds blocks at their poses, at rest; they get the ids 1, 2, … in order.

        Raises `ValueError` if there already are blocks, or the lengths differ.
        """
        if self._blocks:
            raise ValueError("the world already has blocks: call reset() first")
        self._set_global_parameters()
        for number, (block, pose) in enumerate(zip(blocks, poses, strict=True), start=1):
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_BOX,
                halfExtents=[edge / 2 for edge in block.edges_m],
                physicsClientId=self._client,
            )
            volume = block.edges_m[0] * block.edges_m[1] * block.edges_m[2]
            body = pybullet.createMultiBody(
                baseMass=BLOCK_DENSITY_KG_M3 * volume,
                baseCollisionShapeIndex=shape,
                basePosition=pose.position,
                baseOrientation=pose.orientation,
                physicsClientId=self._client,
            )
            self._set_surface(body)
            self._blocks[number] = block
            self._bodies[number] = body

    def reset(self) -> None:
        """Removes all blocks; table and robot do not change."""
        self._blocks.clear()
        self._bodies.clear()
        self._build()

    def place(self, block_id: int, pose: Pose) -> None:
        """Holds a block `DROP_M` above the goal, at rest; `settle()` releases it."""
        self._set_global_parameters()
        x, y, z = pose.position
        pybullet.resetBasePositionAndOrientation(
            self._body(block_id),
            (x, y, z + DROP_M),
            pose.orientation,
            physicsClientId=self._client,
        )
        pybullet.resetBaseVelocity(
            self._body(block_id), (0, 0, 0), (0, 0, 0), physicsClientId=self._client
        )

    def settle(self) -> Settled:
        """Steps until every block has been at rest for `REST_STEPS` steps, at most
        `MAX_STEPS` steps."""
        self._set_global_parameters()
        quiet = 0
        for step in range(1, MAX_STEPS + 1):
            self._step()
            quiet = quiet + 1 if self.slow() else 0
            if quiet == REST_STEPS:
                return Settled(True, step)
        return Settled(False, MAX_STEPS)

    @property
    def time_s(self) -> float:
        """Simulated time since the world was created."""
        return self._steps * TIME_STEP_S

    def pose(self, block_id: int) -> Pose:
        """The pose of a block's centre. Raises `KeyError` for an unknown id."""
        position, orientation = pybullet.getBasePositionAndOrientation(
            self._body(block_id), physicsClientId=self._client
        )
        return Pose(tuple(position), tuple(orientation))

    def poses(self) -> dict[int, Pose]:
        """The poses of all blocks by id."""
        return {block_id: self.pose(block_id) for block_id in self._bodies}

    def nearest(self, position: ArrayLike) -> tuple[int, float]:
        """The block whose centre is closest to a point, and its distance in metres."""
        distance_m, block_id = min(
            (float(np.linalg.norm(np.subtract(pose.position, position))), block_id)
            for block_id, pose in self.poses().items()
        )
        return block_id, distance_m

    def placed(self) -> tuple[PlacedBlock, ...]:
        """All blocks with their poses, in the order of their ids."""
        return tuple(
            PlacedBlock(block_id, block, self.pose(block_id))
            for block_id, block in self._blocks.items()
        )

    def slow(self) -> bool:
        """Whether every block is below both speed limits of a block at rest."""
        for body in self._bodies.values():
            (vx, vy, vz), (wx, wy, wz) = pybullet.getBaseVelocity(
                body, physicsClientId=self._client
            )
            if vx * vx + vy * vy + vz * vz > REST_SPEED_M_S**2:
                return False
            if wx * wx + wy * wy + wz * wz > REST_TURN_RAD_S**2:
                return False
        return True

    def arm_links(self) -> dict[str, Pose]:
        """The frame of each of the Panda's links by name; empty without robot."""
        return dict(self._links)

    def _step(self) -> None:
        pybullet.stepSimulation(physicsClientId=self._client)
        self._steps += 1

    def _body(self, block_id: int) -> int:
        if block_id not in self._bodies:
            raise KeyError(f"no block {block_id}: the world has {sorted(self._bodies)}")
        return self._bodies[block_id]

    def _set_surface(self, body: int) -> None:
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=FRICTION,
            spinningFriction=0.0,
            rollingFriction=0.0,
            restitution=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=self._client,
        )

    def _set_global_parameters(self) -> None:
        pybullet.setPhysicsEngineParameter(
            contactBreakingThreshold=CONTACT_BREAKING_M, physicsClientId=self._client
        )

    def _build(self) -> None:
        """Builds an empty table in a fresh engine: removed bodies would leave traces in the order
        in which contacts are solved."""
        pybullet.resetSimulation(physicsClientId=self._client)
        pybullet.setGravity(0, 0, -GRAVITY_M_S2, physicsClientId=self._client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP_S,
            numSolverIterations=SOLVER_ITERATIONS,
            numSubSteps=0,
            restitutionVelocityThreshold=0.2,
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )
        self._set_global_parameters()
        half = [(high - low) / 2 for low, high in zip(TABLE_LOW, TABLE_HIGH, strict=True)]
        middle = [(high + low) / 2 for low, high in zip(TABLE_LOW, TABLE_HIGH, strict=True)]
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=self._client
        )
        self._table = pybullet.createMultiBody(
            baseMass=0,
            baseCollisionShapeIndex=shape,
            basePosition=middle,
            physicsClientId=self._client,
        )
        self._set_surface(self._table)
