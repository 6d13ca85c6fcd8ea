"""What comes of the sub-goals: the arm carries each block to its own, or physics alone does
with blocks that are set down there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import nsrm

from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.execute import Mark
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, SubGoalReached
from nsrm_harness.manipulation.robot_interface import RobotInterface, StuckError
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.perception.observer import Observation, Observer
from nsrm_harness.simulation.world import World
from nsrm_harness.visualization.demo_listener import StepResult, Stopped

Goal = tuple[int, Pose]
"""The number of an object, and where its centre is to be."""


Tell = Callable[[int, Any], None]
"""Is told the index of a step and how it went."""


def untold(index: int, outcome: StepResult) -> None:
    """Tells nobody."""


@dataclass(frozen=True)
class PhysicsPlacement:
    """How one sub-goal went, without an arm.

    * `miss_m`: between where the block rests and its sub-goal
    * `shift_m`: the farthest that any other block was shifted
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
    """Puts each block, the one nearest to where the object is seen, in place, and settles after
    each; the world is changed.

    * `tell`: is told each outcome, when it has come
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
    eyes: Observer,
    model: nsrm.Model,
    sentence: str,
    name: Callable[[int], str],
    mark: Mark,
    looked: Callable[[Observation], None],
    tell: Tell = untold,
) -> list[SubGoalReached | Stopped]:
    """Has the arm follow a sentence, step by step, until all is done or a step can't be.

    * `name`: what an object is called, by its number
    * `looked`: is told what is seen, each time
    * `tell`: is told each outcome, when it has come; of a step that was undone and done again the
      last one counts

    Raises `nsrm.Refused` if there is no plan.
    """
    outcomes: dict[int, SubGoalReached | Stopped] = {}
    begun: list[int] = []

    def told(index: int, outcome: SubGoalReached | Stopped) -> None:
        outcomes[index] = outcome
        tell(index, outcome)

    loop = ClosedLoop(
        body,
        PickAndPlacePlanner(),
        eyes,
        model,
        name,
        mark,
        looked=looked,
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
