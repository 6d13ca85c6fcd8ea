"""Runs one episode with an injected fault, with a closed or an open loop, and judges it by the
ground truth."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.manipulation_trials.episode import (
    EpisodeEnd,
    EpisodeResult,
    TrialEpisode,
    lasting,
    planner,
    renderer,
)
from nsrm_harness.evaluation.manipulation_trials.fault_injection import (
    BEGUN,
    FAULTS,
    FaultyArm,
    FaultyCamera,
    InjectedFault,
)
from nsrm_harness.evaluation.manipulation_trials.judge import SHIFT_M, PlacementVerdict
from nsrm_harness.evaluation.manipulation_trials.open_loop import BlindMover
from nsrm_harness.evaluation.manipulation_trials.rows import MAX_TRIES, Drawn, TrialRow, draw
from nsrm_harness.geometry import panda
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.robot_interface import StuckError, wait
from nsrm_harness.perception.observer import Observer
from nsrm_harness.simulation.layout import LayoutError

Loop = Literal["closed", "open"]

MOST_KINDS = 64
"""Maximum number of kinds of faults: each episode of each kind has its own index."""
MOST_STEPS = 2
READY_RAD, STILL_RAD = 0.02, 0.001
"""Tolerances of the joints for an arm in its ready pose, and for one that stands still."""
CALM_S = 0.5
"""Time for the arm to come to rest before it is judged, and over which it must stand still."""


@dataclass(frozen=True)
class DisturbedRow(TrialRow):
    """A row of episodes with one kind of fault."""

    kind: str = ""
    loop: Loop = "closed"


DISTURBED_ROWS = tuple(
    DisturbedRow(
        f"{kind}_{loop}",
        f"{fault.title}: loop {loop}",
        0.95 if loop == "closed" else 0.0,
        MOST_STEPS,
        is_stack=fault.is_stack,
        is_disturbed=True,
        kind=kind,
        loop=loop,
    )
    for kind, fault in FAULTS.items()
    for loop in ("closed", "open")
)
"""For each kind of fault, the closed loop, and the open loop for comparison, which has no goal to
meet."""


def run_disturbed(
    kind: str,
    loop: Loop,
    seed: int,
    index: int,
    films: Path | None = None,
    domain: Domain | None = None,
) -> EpisodeResult:
    """Runs one episode, with the same result in any process and the same fault in either loop.

    It succeeds if everything is done as said, or if what is impossible ends at rest with a failure
    that is reported.

    * `films`, `domain`: see `trial.run`
    """
    number = list(FAULTS).index(kind)
    rng = generator(seed, "arm_disturbed", MOST_KINDS * index + number)
    with closing(FaultyArm()) as arm:
        drawn, fault = _draw(kind, arm, rng, domain or domains.load())
        episode = _Disturbed(arm, drawn, films, fault, loop)
        return episode.carry_out(f"{kind}_{loop}", index)


def _draw(
    kind: str, arm: FaultyArm, rng: np.random.Generator, domain: Domain
) -> tuple[Drawn, InjectedFault]:
    """A scene with one or two steps in which the fault is possible."""
    fault = FAULTS[kind]
    for _ in range(MAX_TRIES):
        steps = MOST_STEPS if fault.is_stack else int(rng.integers(1, MOST_STEPS + 1))
        row = TrialRow(kind, "", 0.0, steps, is_stack=fault.is_stack)
        drawn = draw(row, rng, domain)
        try:
            return drawn, fault(arm, drawn, rng)
        except LayoutError:
            continue
    raise HarnessError(f"{kind}: no scene in which it can be done after {MAX_TRIES} tries")


class _Disturbed(TrialEpisode):
    def __init__(
        self,
        arm: FaultyArm,
        drawn: Drawn,
        films: Path | None,
        fault: InjectedFault,
        loop: Loop,
    ) -> None:
        super().__init__(arm, drawn, films)
        self._arm, self._fault, self._loop_kind = arm, fault, loop
        self._is_clearing, self._reached_before = False, 0
        self._put_aside, self._cleared = set[int](), set[int]()
        self._before = arm.poses()

    def _followed(self) -> EpisodeEnd:
        wait(self._arm, CALM_S)
        if why := self._undone():
            return EpisodeEnd("failed", f"{why}, and no failure was reported")
        if not (self._arm.slow() and self._is_ready()):
            return EpisodeEnd("failed", "it is not at rest")
        if others := self._others():
            return EpisodeEnd("failed", f"{others} moved")
        if not self._fault.has_acted:
            return EpisodeEnd("failed", "it ended before it was disturbed")
        return EpisodeEnd("succeeded")

    def _undone(self) -> str:
        """What was not done as said; each step is judged by its last attempt."""
        last = {verdict.step: verdict for verdict in self._verdicts}
        for step in range(len(self._moves)):
            if step not in last:
                return f"step {step + 1} was never begun"
            if not last[step].is_in_place:
                return f"step {step + 1} is not done as said ({last[step]})"
        if not self._judge.stands(lasting(self._moves)):
            return "what was done did not stay"
        return ""

    def _stopped(self, told: EpisodeEnd, error: Exception) -> EpisodeEnd:
        """The end after a reported failure, which may be the right one."""
        wait(self._arm, CALM_S)
        joints = self._arm.joints()
        wait(self._arm, CALM_S)
        is_still = bool(np.abs(self._arm.joints() - joints).max() < STILL_RAD)
        if not (is_still and self._arm.slow()):
            return replace(told, end="failed", why=f"{told.why}; it is not at rest")
        if self._arm.has_opened_astray:
            why = f"{told.why}; it has let go where it was not to"
            return replace(told, end="failed", why=why)
        if others := self._others():
            return replace(told, end="failed", why=f"{told.why}; {others} moved")
        if not (isinstance(error, StuckError) or self._is_ready()):
            return replace(told, end="failed", why=f"{told.why}; it is not in its ready pose")
        is_right = self._fault.has_acted and self._fault.explains(error)
        if is_right and told.end == "failed":
            return replace(told, end="succeeded")
        return told

    def _observer(self) -> Observer:
        return Observer(FaultyCamera(renderer(), self._arm, default_camera(), self._fault))

    def _follow(self) -> None:
        loop = self._loop()
        if self._loop_kind == "open":
            loop.mover = BlindMover(self._arm, planner(), loop.seen, self._mark)
            loop.follow(self._drawn.sentence, "open_loop")
        else:
            loop.follow(self._drawn.sentence)

    def _begin(self, index: int) -> Pose:
        self._is_clearing, self._cleared = False, set()
        self._reached_before = len(self._performed)
        goal = super()._begin(index)
        self._mark(BEGUN)
        return goal

    def _mark(self, event: str) -> None:
        super()._mark(event)
        if event == "grasped" and self._is_clearing:
            self._cleared.add(self._nearest(self._arm.fingers_at()))
        if event in ("clearing", "cleared"):
            self._is_clearing = event == "clearing"
        elif not self._is_clearing:
            self._fault.mark(self._step, event)

    def _tick(self) -> None:
        self._others_tick()
        self._fault.tick()
        self._judge.tick()

    def _end(self, index: int) -> None:
        reached = self._performed[self._reached_before :]
        self._put_aside |= {self._nearest(place) for done in reached for place in done.aside}
        if not reached:
            # What it moved aside before the command failed.
            self._put_aside |= self._cleared
        super()._end(index)

    def _verdict(self) -> PlacementVerdict:
        return self._judge.end(self._aside(), by_current_reference=True)

    def _nearest(self, pose: Pose) -> int:
        """The index of the block nearest to this pose."""
        return self._arm.nearest(pose.position)[0] - 1

    def _aside(self) -> list[Pose]:
        return [self._arm.pose(index + 1) for index in self._handled()]

    def _is_ready(self) -> bool:
        return bool(np.abs(self._arm.joints() - panda.READY_RAD).max() < READY_RAD)

    def _handled(self) -> set[int]:
        """The indices of the blocks that were expected to move: by a step, moved aside as reported,
        or by the fault."""
        moved = {move.moved for move in self._moves}
        return moved | self._put_aside | self._fault.meddled

    def _others(self) -> str:
        """The names of the blocks that are displaced although nothing was to move them."""
        handled = self._handled()
        return " and ".join(
            f"block {number}"
            for number, pose in self._arm.poses().items()
            if number - 1 not in handled and pose.distance_m(self._before[number]) > SHIFT_M
        )
