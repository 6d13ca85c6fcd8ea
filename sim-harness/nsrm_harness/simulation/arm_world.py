"""The tabletop with a motorised arm, which moves blocks only by contact."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.bullet import pybullet
from nsrm_harness.simulation.moving_arm import MovingArm
from nsrm_harness.simulation.world import TIME_STEP_S, World

TABLE = "table"


Touching = int | str
"""A body in contact: a block by number, the arm's links and the table by name."""


class Contact(NamedTuple):
    """Two bodies that push against each other, sorted by name."""

    one: Touching
    other: Touching

    def __str__(self) -> str:
        return f"{called(self.one)} and {called(self.other)}"


def called(it: Touching) -> str:
    """The name of a body in contact, for people."""
    return f"block {it}" if isinstance(it, int) else it


class ArmWorld(World):
    """A `World` whose arm is part of the physics and moved by motors; it implements the robot
    interface of `nsrm_harness.manipulation`.

    * `on_tick`: called before each physics step for which the arm waits
    """

    def __init__(self, on_tick: Callable[[], None] = lambda: None) -> None:
        super().__init__()
        self.on_tick = on_tick

    def _build(self) -> None:
        super()._build()
        pybullet.setPhysicsEngineParameter(enableConeFriction=1, physicsClientId=self._client)
        self._arm = MovingArm(self._client)

    @property
    def tick_s(self) -> float:
        """Time between two ticks."""
        return TIME_STEP_S

    def drive(self, joints: NDArray[np.float64], speeds: NDArray[np.float64]) -> None:
        """Sets the target of the joints, rad and rad/s, from the next tick on."""
        self._arm.drive(joints, speeds)

    def grip(self, opening_m: float, force_n: float) -> None:
        """Sets the target opening of the fingers and their largest force, from the next tick on."""
        self._arm.grip(opening_m, force_n)

    def joints(self) -> NDArray[np.float64]:
        """The joints' angles `[7]`, radians."""
        return self._arm.joints()

    def opening_m(self) -> float:
        """Opening between the fingers."""
        return self._arm.opening_m()

    def tick(self) -> None:
        """Advances the physics by one step."""
        self.on_tick()
        self._set_global_parameters()
        self._step()

    def arm_links(self) -> dict[str, Pose]:
        """The frame of each of the Panda's links in the world, by name."""
        return self._arm.links()

    def contacts(self, *block_ids: int) -> set[Contact]:
        """Current contacts of the arm and of these blocks."""
        points = [
            *self._arm.contact_points(),
            *(
                point
                for block_id in block_ids
                for point in pybullet.getContactPoints(
                    bodyA=self._body(block_id), physicsClientId=self._client
                )
            ),
        ]
        # Two bodies touch at several points: each pair is named once.
        pairs = {
            (one, link, other, other_link)
            for _, one, other, link, other_link, *_, force_n, _, _, _, _ in points
            if force_n > 0
        }
        names: dict[int, Touching] = {body: number for number, body in self._bodies.items()}
        names[self._table] = TABLE
        found = set()
        for one, link, other, other_link in pairs:
            pair = (
                names.get(one) or self._arm.link_name(link),
                names.get(other) or self._arm.link_name(other_link),
            )
            found.add(Contact(*sorted(pair, key=called)))
        return found
