"""Plans a regrasp: where a block is set down on the way if no single grasp works both where it
stands and at its goal. All of it is planned before anything moves."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusalReason, RefusedError
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.relocation import Relocation, with_room
from nsrm_harness.manipulation.stability import gap_m


def plan_regrasp(
    planner: PickAndPlacePlanner,
    objects: Mapping[str, Cuboid],
    name: str,
    goal: Pose,
    begin: Joints,
    refusal: RefusedError,
) -> tuple[Relocation, ...]:
    """Where a block is set down, so that it can be picked up again by other faces or with another
    tilt, and carried to its sub-goal; empty if that does not help. Only the place that is farthest
    from all other objects is tried: what fails there hardly ever works elsewhere.

    * `objects`, `begin`: see `PickAndPlacePlanner.carry`
    * `refusal`: why the block cannot be carried directly
    """
    if refusal.why is not RefusalReason.NO_PATH:
        return ()
    block = objects[name]
    others = [cuboid for key, cuboid in objects.items() if key != name]
    place = max(
        with_room(block, others), key=lambda place: _room_m(place, block, others), default=None
    )
    if place is None:
        return ()
    try:
        planner.carry(objects, name, place, begin)
        moved = {**objects, name: Cuboid(place, block.edges_m)}
        planner.carry(moved, name, goal, panda.READY_RAD)
    except RefusedError:
        return ()
    return ((name, place),)


def _room_m(place: Pose, block: Cuboid, others: Collection[Cuboid]) -> float:
    """The distance between a block at this place and the object nearest to it."""
    put = Cuboid(place, block.edges_m)
    return min((gap_m(put, other) for other in others), default=0.0)
