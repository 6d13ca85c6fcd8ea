"""What a disturbed episode comes to without the loop: planned from the first picture, and carried
out as if nothing could go wrong."""

from __future__ import annotations

from collections.abc import Callable

import nsrm

from nsrm_harness.manipulation.execute import Mark, execute
from nsrm_harness.manipulation.follow import numbered
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.robot_interface import RobotInterface
from nsrm_harness.perception.observer import Observer, sub_goal


def follow_blindly(
    body: RobotInterface,
    planner: PickAndPlacePlanner,
    eyes: Observer,
    model: nsrm.Model,
    sentence: str,
    mark: Mark,
    begin: Callable[[int], object],
    end: Callable[[int], None],
) -> None:
    """Has the arm carry each block once to where the plan of the first picture has it go, believed
    to stand where it was put before.

    Raises `nsrm.Refused`, `RefusedError` and `StuckError` as `Follower.follow`.
    """
    sight = eyes.look()
    plan = model.plan(sight.scene(model, eyes.camera), sentence)
    believed = {numbered(number): cuboid for number, cuboid in sight.cuboids.items()}
    for index, step in enumerate(plan.steps):
        name = numbered(step.object_id)
        begin(index)
        try:
            carry = planner.carry(believed, name, sub_goal(step), body.joints())
            execute(body, carry, mark)
        finally:
            end(index)
        believed[name] = carry.placement.cuboid
