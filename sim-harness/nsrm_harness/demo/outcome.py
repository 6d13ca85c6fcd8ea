"""What physics makes of the sub-goals: each block is put at its own, in order, let go,
and left to come to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nsrm_harness.world.pose import Pose
from nsrm_harness.world.world import World


@dataclass(frozen=True)
class Landing:
    """How one sub-goal went."""

    object_id: int
    #: Between where the block rests and its sub-goal, metres.
    miss_m: float
    #: The farthest that any other block was shifted, metres.
    shift_m: float
    at_rest: bool

    def __str__(self) -> str:
        rest = "comes to rest" if self.at_rest else "has not come to rest"
        return (
            f"object {self.object_id} {rest} {1000 * self.miss_m:.1f} mm from its sub-goal; "
            f"others moved {1000 * self.shift_m:.1f} mm at most"
        )


def carry_out(world: World, sub_goals: Sequence[tuple[int, Pose]]) -> list[Landing]:
    """Puts each (object, pose) in place and settles after each; the world is changed."""
    landings = []
    for object_id, goal in sub_goals:
        before = world.poses()
        world.place(object_id, goal)
        settled = world.settle()
        after = world.poses()
        shifts = [after[other].distance_m(before[other]) for other in after if other != object_id]
        landings.append(
            Landing(
                object_id,
                after[object_id].distance_m(goal),
                max(shifts, default=0.0),
                settled.at_rest,
            )
        )
    return landings
