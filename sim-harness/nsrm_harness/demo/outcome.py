"""What comes of the sub-goals: the arm carries each block to its own, or physics alone does
with blocks that are set down there."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

from nsrm_harness.arm.carry import Planner
from nsrm_harness.arm.execute import Body, Mark, StuckError
from nsrm_harness.arm.perform import FailedError, Performed, perform
from nsrm_harness.arm.refused import RefusedError
from nsrm_harness.perception.cuboids import Cuboid
from nsrm_harness.sight import Sight
from nsrm_harness.world.pose import Pose
from nsrm_harness.world.world import World

Goal = tuple[int, Pose]
"""The number of an object, and where its centre is to be."""


class Outcome(Protocol):
    """How one sub-goal went: a text for people, and the same for programs."""

    def __str__(self) -> str: ...

    def as_json(self) -> dict[str, Any]: ...


def untold(outcome: Outcome) -> None:
    """Tells nobody."""


@dataclass(frozen=True)
class Landing:
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
    world: World, sight: Sight, goals: Sequence[Goal], tell: Callable[[Outcome], None] = untold
) -> list[Landing]:
    """Puts each block, the one nearest to where the object is seen, in place, and settles after
    each; the world is changed.

    * `tell`: is told each outcome, when it has come
    """
    blocks = {
        number: world.nearest(cuboid.pose.position)[0] for number, cuboid in sight.cuboids.items()
    }
    landings = []
    for number, goal in goals:
        block_id = blocks[number]
        before = world.poses()
        world.place(block_id, goal)
        settled = world.settle()
        after = world.poses()
        shifts = [after[other].distance_m(before[other]) for other in after if other != block_id]
        landings.append(
            Landing(
                number,
                after[block_id].distance_m(goal),
                max(shifts, default=0.0),
                settled.at_rest,
            )
        )
        tell(landings[-1])
    return landings


@dataclass(frozen=True)
class Stopped:
    """Why the arm did not carry a sub-goal out; those after it are not begun.

    * `moved`: whether it began
    """

    moved: bool
    message: str

    def __str__(self) -> str:
        return f"{'failed' if self.moved else 'refused'}: {self.message}"

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {"failed" if self.moved else "refused": self.message}


def carry(
    body: Body,
    look: Callable[[], Sight],
    goals: Sequence[Goal],
    names: Mapping[int, str],
    mark: Mark,
    keep: Collection[int] = (),
    tell: Callable[[Outcome], None] = untold,
) -> list[Performed | Stopped]:
    """Has the arm carry each block to its sub-goal, until one can't be.

    * `keep`: the objects that are not moved aside for another
    * `tell`: is told each outcome, when it has come
    """

    def seen() -> dict[str, Cuboid]:
        return {
            # One that was not there before has no name yet.
            names.get(number, f"object {number}"): cuboid
            for number, cuboid in look().cuboids.items()
        }

    planner = Planner()
    kept = {names[number] for number in keep}
    outcomes: list[Performed | Stopped] = []
    for number, goal in goals:
        try:
            outcomes.append(perform(body, planner, seen, names[number], goal, mark, keep=kept))
        except (RefusedError, FailedError, StuckError) as error:
            outcomes.append(Stopped(not isinstance(error, RefusedError), str(error)))
        tell(outcomes[-1])
        if isinstance(outcomes[-1], Stopped):
            break
    return outcomes
