"""Executes the sub-goals of the demonstration: the arm carries each block to its own, or without an
arm, blocks are released at their sub-goals and physics decides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import nsrm

from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, SubGoalReached
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.perception.observer import Observation, Observer
from nsrm_harness.simulation.world import World
from nsrm_harness.visualization.demo_listener import DemoListener, StepResult, Stopped

Goal = tuple[int, Pose]
"""The number of an object, and the pose to which its centre is moved."""


Tell = Callable[[int, Any], None]
"""Called with the index of a step and its result."""


def untold(index: int, outcome: StepResult) -> None:
    """Ignores the result."""


@dataclass(frozen=True)
class PhysicsPlacement:
    """The result of one sub-goal without an arm.

    * `miss_m`: distance from the sub-goal to where the block comes to rest
    * `shift_m`: largest displacement of any other block
    """

    object_id: int
    miss_m: float
    shift_m: float
    at_rest: bool

    def __str__(self) -> str:
        rest = "comes to rest" if self.at_rest else "has not come to rest"
        return (
            f"object {self.object_id} {rest} {1000 * self.miss_m:.1f} mm from its sub-goal; "
            f"others moved {1000 * self.shift_m:.1f} mm at most"
        )

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {key: value for key, value in asdict(self).items() if key != "object_id"}


def set_down(
    world: World, sight: Observation, goals: Sequence[Goal], tell: Tell = untold
) -> list[PhysicsPlacement]:
    """Places the block nearest to where each object is seen at its sub-goal, and lets the world
    settle after each; changes the world.

    * `tell`: called with each result as it becomes known
    """
    blocks = {
        number: world.nearest(cuboid.pose.position)[0] for number, cuboid in sight.cuboids.items()
    }
    landings = []
    for index, (number, goal) in enumerate(goals):
        block_id = blocks[number]
        before = world.poses()
        world.place(block_id, goal)
        settled = world.settle()
        after = world.poses()
        shifts = [after[other].distance_m(before[other]) for other in after if other != block_id]
        landings.append(
            PhysicsPlacement(
                number,
                after[block_id].distance_m(goal),
                max(shifts, default=0.0),
                settled.at_rest,
            )
        )
        tell(index, landings[-1])
    return landings


def carry(
    body: RobotInterface,
    observer: Observer,
    model: nsrm.Model,
    sentence: str,
    name: Callable[[int], str],
    listener: DemoListener,
) -> list[SubGoalReached | Stopped]:
    """Has the arm execute a sentence, step by step, until it is done or a step fails.

    * `name`: the name of an object, by its number
    * `listener`: notified of each observation, of the arm's events, and of each result as it
      becomes known; if a step was undone and done again, the last result counts

    Raises `nsrm.Refused` if there is no plan.
    """
    outcomes: dict[int, SubGoalReached | Stopped] = {}
    begun: list[int] = []

    def told(index: int, outcome: SubGoalReached | Stopped) -> None:
        outcomes[index] = outcome
        listener.ended(index, outcome)

    loop = ClosedLoop(
        body,
        PickAndPlacePlanner(),
        observer,
        model,
        name,
        listener.mark,
        looked=listener.looked,
        begin=begun.append,
        reached=told,
    )
    try:
        loop.follow(sentence)
    except nsrm.Refused as refusal:
        if not begun:
            raise
        told(begun[-1], Stopped(True, f"then there was no plan for what is left: {refusal}"))
    except (RefusedError, ManipulationError, StuckError) as error:
        if not begun:
            raise
        told(begun[-1], Stopped(not isinstance(error, RefusedError), str(error)))
    return [outcomes[index] for index in sorted(outcomes)]
