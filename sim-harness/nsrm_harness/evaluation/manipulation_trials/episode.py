"""Runs one episode: the arm executes a sentence, the judge watches at each tick, and a film is
recorded on request."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import nsrm

from nsrm_harness.data.moves import Move
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementJudge, PlacementVerdict
from nsrm_harness.evaluation.manipulation_trials.rows import Drawn
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.execute import unmarked
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, SubGoalReached
from nsrm_harness.manipulation.robot_interface import StuckError
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.perception.observer import Observer
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render import Renderer, open_renderer
from nsrm_harness.visualization.film import Film


@dataclass(frozen=True)
class EpisodeResult:
    """How an episode ended.

    * `end`: "succeeded", "refused" (a sub-goal was refused, with a reason, before anything moved
      for it) or "failed"
    * `why`: the reason, or what did not succeed
    * `kind`: kind of a refusal: the model's, or one of `RefusalReason`; empty otherwise
    * `steps`: a verdict on each attempt at a step
    * `corrected_m`, `tries`: for each sub-goal that was reached: see `SubGoalReached`
    """

    row: str
    index: int
    sentence: str
    end: str
    why: str
    kind: str
    steps: tuple[PlacementVerdict, ...]
    corrected_m: tuple[float, ...]
    tries: tuple[int, ...]


@dataclass(frozen=True)
class EpisodeEnd:
    """`end`, `why` and `kind` of `EpisodeResult`."""

    end: str
    why: str = ""
    kind: str = ""


class TrialEpisode(ABC):
    """What all episodes have in common.

    * `films`: folder for `film.gif` and `strip.png`
    """

    def __init__(self, world: ArmWorld, drawn: Drawn, films: Path | None) -> None:
        world.spawn(drawn.arrangement.blocks, drawn.arrangement.poses)
        world.settle()
        self._world, self._drawn, self._films = world, drawn, films
        self._moves, self._step = drawn.task.moves, 0
        self._film = Film(world, renderer(), small=True) if films else None
        self._judge = PlacementJudge(world, drawn.arrangement.blocks)
        self._verdicts: list[PlacementVerdict] = []
        self._performed: list[SubGoalReached] = []
        self._is_open, self._reached = False, 0
        self._others_tick = world.on_tick
        world.on_tick = self._tick

    def carry_out(self, row: str, index: int) -> EpisodeResult:
        """Runs the episode to its end, whatever that is.

        * `row`, `index`: identify it in the result
        """
        end = self._end_of()
        if self._film and self._films:
            self._films.mkdir(parents=True, exist_ok=True)
            self._film.save(self._films)
        return EpisodeResult(
            row,
            index,
            self._drawn.sentence,
            end.end,
            end.why,
            end.kind,
            tuple(self._verdicts),
            tuple(done.corrected_m for done in self._performed),
            tuple(done.tries for done in self._performed),
        )

    def _end_of(self) -> EpisodeEnd:
        try:
            self._follow_to_the_end()
        except nsrm.Refused as refusal:
            return self._stopped(EpisodeEnd("refused", str(refusal), refusal.kind), refusal)
        except RefusedError as refusal:
            return self._stopped(EpisodeEnd("refused", str(refusal), refusal.why.value), refusal)
        except (ManipulationError, StuckError) as failure:
            return self._stopped(EpisodeEnd("failed", str(failure)), failure)
        return self._followed()

    def _follow_to_the_end(self) -> None:
        try:
            self._follow()
        finally:
            if self._is_open:
                self._close()

    def _follow(self) -> None:
        """Has the arm execute the sentence. Raises as `ClosedLoop.follow`."""
        self._loop().follow(self._drawn.sentence)

    def _loop(self) -> ClosedLoop:
        loop = ClosedLoop(
            self._world,
            planner(),
            self._observer(),
            model(),
            mark=self._mark,
            begin=self._begin,
            end=self._end,
        )
        self._performed = loop.performed
        return loop

    @abstractmethod
    def _observer(self) -> Observer: ...

    @abstractmethod
    def _aside(self) -> list[Pose]:
        """Where blocks were put, in the step that ends, that need not have stayed in place."""

    @abstractmethod
    def _followed(self) -> EpisodeEnd:
        """The end by the ground truth, if nothing was refused and no failure was reported."""

    def _stopped(self, told: EpisodeEnd, error: Exception) -> EpisodeEnd:
        """The end by the ground truth, after the arm has reported `told`.

        * `error`: the exception
        """
        return told

    def _mark(self, event: str) -> None:
        (self._film.mark if self._film else unmarked)(event)

    def _tick(self) -> None:
        self._others_tick()
        self._judge.tick()

    def _begin(self, index: int) -> Pose:
        """Called before a command for a step: begins an attempt at it, or continues the attempt if
        the previous command failed."""
        # If more steps were understood than the sentence has, the further ones are judged as the
        # last one.
        step = min(index, len(self._moves) - 1)
        if self._is_open and step != self._step:
            self._close()
        if not self._is_open:
            self._step, self._is_open, self._reached = step, True, len(self._performed)
            self._goal = self._judge.begin(self._moves[step])
        return self._goal

    def _end(self, index: int) -> None:
        """Called after a command; ends the attempt if the step was reached."""
        if self._reached_now():
            self._close()

    def _close(self) -> None:
        self._is_open = False
        verdict = self._verdict()
        # An attempt that was refused has not begun.
        if verdict.seconds > 0:
            self._verdicts.append(replace(verdict, step=self._step))

    def _reached_now(self) -> list[SubGoalReached]:
        """The sub-goals that were reached in this attempt."""
        return self._performed[self._reached :]

    def _verdict(self) -> PlacementVerdict:
        return self._judge.end(self._aside())


def lasting(moves: Sequence[Move]) -> list[Move]:
    """The moves after which neither the moved block nor its reference is moved again."""
    return [
        move
        for index, move in enumerate(moves)
        if not {move.moved, move.reference} & {later.moved for later in moves[index + 1 :]}
    ]


@lru_cache(maxsize=1)
def renderer() -> Renderer:
    """The renderer of this process."""
    return open_renderer()


@lru_cache(maxsize=1)
def model() -> nsrm.Model:
    """The built-in model."""
    return nsrm.Model.pretrained()


@lru_cache(maxsize=1)
def planner() -> PickAndPlacePlanner:
    """The planner of this process."""
    return PickAndPlacePlanner()
