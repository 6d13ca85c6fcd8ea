"""One episode that is disturbed on purpose, with the loop closed or open, judged by the truth."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import nsrm
import numpy as np

from nsrm_harness import domain as domains
from nsrm_harness.arm import panda
from nsrm_harness.arm.execute import Mark, StuckError, unmarked, wait
from nsrm_harness.arm.perform import FailedError, Performed
from nsrm_harness.arm.refused import RefusedError
from nsrm_harness.arm_trials.disturb import (
    BEGUN,
    DISTURBANCES,
    Disturbance,
    DisturbedArm,
    DisturbedEyes,
)
from nsrm_harness.arm_trials.judge import SHIFT_M, Judge, Verdict
from nsrm_harness.arm_trials.open_loop import follow_blindly
from nsrm_harness.arm_trials.rows import MAX_TRIES, Drawn, Row, draw
from nsrm_harness.arm_trials.trial import Ended, lasting, model, planner, renderer
from nsrm_harness.demo.film import Film
from nsrm_harness.episodes.seeds import generator
from nsrm_harness.errors import HarnessError
from nsrm_harness.follow import Follower
from nsrm_harness.world.camera import default_camera
from nsrm_harness.world.layout import LayoutError

Loop = Literal["closed", "open"]

MOST_KINDS = 64
"""Of disturbances: each episode of each has an index of its own."""
MOST_STEPS = 2
READY_RAD, STILL_RAD = 0.02, 0.001
"""An arm is in its ready pose, or stands still, within that,"""
CALM_S = 0.5
"""after so long."""


@dataclass(frozen=True)
class DisturbedRow(Row):
    """Episodes with one kind of disturbance."""

    kind: str = ""
    loop: Loop = "closed"


DISTURBED_ROWS = tuple(
    DisturbedRow(
        f"{kind}_{loop}",
        f"{disturbance.title}: loop {loop}",
        0.95 if loop == "closed" else 0.0,
        MOST_STEPS,
        is_stack=disturbance.is_stack,
        is_disturbed=True,
        kind=kind,
        loop=loop,
    )
    for kind, disturbance in DISTURBANCES.items()
    for loop in ("closed", "open")
)
"""The closed loop of each kind, and the open one below it for comparison, which has no goal."""


def run_disturbed(kind: str, loop: Loop, seed: int, index: int, films: Path | None = None) -> Ended:
    """Carries one episode out; the same in any process, and disturbed alike with either loop.

    It has succeeded when all is done as said, or when what can't be done has ended in a failure
    in words, at rest.

    * `films`: see `trial.run`
    """
    number = list(DISTURBANCES).index(kind)
    rng = generator(seed, "arm_disturbed", MOST_KINDS * index + number)
    with closing(DisturbedArm()) as arm:
        drawn, disturbance = _draw(kind, arm, rng)
        arm.spawn(drawn.arrangement.blocks, drawn.arrangement.poses)
        arm.settle()
        film = Film(arm, renderer()) if films else None
        episode = _Episode(arm, drawn, disturbance, film.mark if film else unmarked)
        end, why, refusal = episode.carry_out(loop)
        if film and films:
            films.mkdir(parents=True, exist_ok=True)
            film.save(films)
    return Ended(
        f"{kind}_{loop}",
        index,
        drawn.sentence,
        end,
        why,
        refusal,
        tuple(episode.verdicts),
        tuple(done.corrected_m for done in episode.performed),
        tuple(done.tries for done in episode.performed),
    )


def _draw(kind: str, arm: DisturbedArm, rng: np.random.Generator) -> tuple[Drawn, Disturbance]:
    """A scene with one or two steps in which there is room for the disturbance."""
    disturbance = DISTURBANCES[kind]
    for _ in range(MAX_TRIES):
        steps = MOST_STEPS if disturbance.is_stack else int(rng.integers(1, MOST_STEPS + 1))
        row = Row(kind, "", 0.0, steps, is_stack=disturbance.is_stack)
        drawn = draw(row, rng, domains.load())
        try:
            return drawn, disturbance(arm, drawn, rng)
        except LayoutError:
            continue
    raise HarnessError(f"{kind}: no scene in which it can be done after {MAX_TRIES} tries")


class _Episode:
    def __init__(
        self, arm: DisturbedArm, drawn: Drawn, disturbance: Disturbance, shown: Mark
    ) -> None:
        self._arm, self._drawn, self._disturbance = arm, drawn, disturbance
        self._shown = shown
        self._moves = drawn.task.moves
        self._judge = Judge(arm, drawn.arrangement.blocks)
        self._step, self._is_clearing = 0, False
        self._carried: set[int] = set()
        self._before = arm.poses()
        self.verdicts: list[Verdict] = []
        self.performed: list[Performed] = []
        self._others_tick = arm.on_tick
        arm.on_tick = self._tick

    def carry_out(self, loop: Loop) -> tuple[str, str, str]:
        """How it ended, why, and what kind of refusal it was."""
        try:
            self._follow(loop)
        except nsrm.Refused as refusal:
            return self._stopped("refused", str(refusal), refusal.kind)
        except RefusedError as refusal:
            return self._stopped("refused", str(refusal), refusal.why.value)
        except FailedError as failure:
            return self._stopped("failed", str(failure), "")
        except StuckError as failure:
            return self._stopped("failed", str(failure), "", must_be_ready=False)
        wait(self._arm, CALM_S)
        if not self._judge.stands(lasting(self._moves)):
            return "failed", "it is not done as said, and no failure was reported", ""
        if not (self._arm.slow() and self._is_ready()):
            return "failed", "it is not at rest", ""
        if others := self._others():
            return "failed", f"{others} moved", ""
        if not self._disturbance.has_acted:
            return "failed", "it ended before it was disturbed", ""
        return "succeeded", "", ""

    def _stopped(
        self, end: str, why: str, refusal: str, *, must_be_ready: bool = True
    ) -> tuple[str, str, str]:
        """With a failure in words, which may be right."""
        wait(self._arm, CALM_S)
        joints = self._arm.joints()
        wait(self._arm, CALM_S)
        is_still = bool(np.abs(self._arm.joints() - joints).max() < STILL_RAD)
        if not (is_still and self._arm.slow()):
            return "failed", f"{why}; it is not at rest", refusal
        if self._arm.has_opened_astray:
            return "failed", f"{why}; it has let go where it was not to", refusal
        if others := self._others():
            return "failed", f"{why}; {others} moved", refusal
        if must_be_ready and not self._is_ready():
            return "failed", f"{why}; it is not in its ready pose", refusal
        if self._disturbance.must_fail and self._disturbance.has_acted and end == "failed":
            return "succeeded", why, refusal
        return end, why, refusal

    def _follow(self, loop: Loop) -> None:
        eyes = DisturbedEyes(renderer(), self._arm, default_camera(), self._disturbance)
        if loop == "open":
            follow_blindly(
                self._arm,
                planner(),
                eyes,
                model(),
                self._drawn.sentence,
                self._mark,
                self._begin,
                self._end,
            )
        else:
            follower = Follower(
                self._arm,
                planner(),
                eyes,
                model(),
                mark=self._mark,
                begin=self._begin,
                end=self._end,
            )
            self.performed = follower.performed
            follower.follow(self._drawn.sentence)

    def _begin(self, index: int) -> None:
        # A sentence of which more steps were understood is judged by its last one.
        self._step, self._is_clearing = min(index, len(self._moves) - 1), False
        self._judge.begin(self._moves[self._step])
        self._mark(BEGUN)

    def _mark(self, event: str) -> None:
        self._shown(event)
        if event == "grasped":
            block_id, _ = self._arm.nearest(self._arm.fingers_at().position)
            self._carried.add(block_id - 1)
        if event in ("clearing", "cleared"):
            self._is_clearing = event == "clearing"
        elif not self._is_clearing:
            self._disturbance.mark(self._step, event)

    def _tick(self) -> None:
        self._others_tick()
        self._disturbance.tick()
        self._judge.tick()

    def _end(self, index: int) -> None:
        verdict = self._judge.end([self._arm.pose(index + 1) for index in self._handled()])
        # What was refused has not begun.
        if verdict.seconds > 0:
            self.verdicts.append(verdict)

    def _is_ready(self) -> bool:
        return bool(np.abs(self._arm.joints() - panda.READY_RAD).max() < READY_RAD)

    def _handled(self) -> set[int]:
        """The indices of the blocks that were moved on purpose, by the arm or by who disturbs."""
        return self._carried | self._disturbance.meddled

    def _others(self) -> str:
        """The names of those that are not where they were, although nobody was to move them."""
        handled = self._handled() | {move.moved for move in self._moves}
        return " and ".join(
            f"block {number}"
            for number, pose in self._arm.poses().items()
            if number - 1 not in handled and pose.distance_m(self._before[number]) > SHIFT_M
        )
