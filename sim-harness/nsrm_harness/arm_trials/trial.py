"""One episode: a sentence is planned by the model, carried out by the arm, and judged by the
truth. The arm sees pictures and feels its joints; the truth is read by the judge."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import nsrm

from nsrm_harness import domain as domains
from nsrm_harness.arm.carry import Planner
from nsrm_harness.arm.execute import Mark, StuckError, unmarked
from nsrm_harness.arm.perform import FailedError, Performed, perform
from nsrm_harness.arm.refused import RefusedError
from nsrm_harness.arm_trials.judge import Judge, Verdict
from nsrm_harness.arm_trials.rows import Drawn, Row, draw
from nsrm_harness.demo.film import Film
from nsrm_harness.episodes.moves import Move
from nsrm_harness.episodes.seeds import generator
from nsrm_harness.follow import Follower
from nsrm_harness.perception.cuboids import Cuboid
from nsrm_harness.sight import Eyes
from nsrm_harness.world.arm_world import ArmWorld
from nsrm_harness.world.camera import default_camera
from nsrm_harness.world.pose import Pose
from nsrm_harness.world.render import Renderer, open_renderer


@dataclass(frozen=True)
class Ended:
    """How an episode ended.

    * `end`: "succeeded", "refused" (a sub-goal was, with a reason, before it moved anything) or
      "failed"
    * `why`: the reason, or what was not as said
    * `kind`: of a refusal: the model's, or one of `arm.refused.Why`; empty otherwise
    * `steps`: a verdict of each attempt at one
    * `corrected_m`, `tries`: of each sub-goal that was reached: see `Performed`
    """

    row: str
    index: int
    sentence: str
    end: str
    why: str
    kind: str
    steps: tuple[Verdict, ...]
    corrected_m: tuple[float, ...]
    tries: tuple[int, ...]


def run(row: Row, seed: int, index: int, films: Path | None = None) -> Ended:
    """Carries one episode out; the same in any process.

    * `films`: folder in which it is shown as `film.gif` and `strip.png`
    """
    drawn = draw(row, generator(seed, f"arm_{row.name}", index), domains.load())
    with closing(ArmWorld()) as world:
        world.spawn(drawn.arrangement.blocks, drawn.arrangement.poses)
        world.settle()
        film = Film(world, renderer()) if films else None
        episode = _Episode(world, drawn, film.mark if film else unmarked)
        end, why, kind = episode.carry_out(with_truth=row.is_control)
        if film and films:
            films.mkdir(parents=True, exist_ok=True)
            film.save(films)
    return Ended(
        row.name,
        index,
        drawn.sentence,
        end,
        why,
        kind,
        tuple(episode.verdicts),
        tuple(done.corrected_m for done in episode.performed),
        tuple(done.tries for done in episode.performed),
    )


class _Episode:
    def __init__(self, world: ArmWorld, drawn: Drawn, mark: Mark) -> None:
        self._world, self._drawn, self._mark = world, drawn, mark
        self._moves = drawn.task.moves
        self._judge = Judge(world, drawn.arrangement.blocks)
        self.verdicts: list[Verdict] = []
        self.performed: list[Performed] = []
        self._others_tick = world.on_tick
        world.on_tick = self._tick

    def _tick(self) -> None:
        self._others_tick()
        self._judge.tick()

    def carry_out(self, *, with_truth: bool) -> tuple[str, str, str]:
        """How it ended, why, and what kind of refusal it was."""
        try:
            if with_truth:
                self._by_truth()
            else:
                self._by_model()
        except nsrm.Refused as refusal:
            return "refused", str(refusal), refusal.kind
        except RefusedError as refusal:
            return "refused", str(refusal), refusal.why.value
        except (FailedError, StuckError) as failure:
            return "failed", str(failure), ""
        for number, verdict in enumerate(self.verdicts, start=1):
            if not verdict.is_as_said:
                return "failed", f"attempt {number} at a step was not as said", ""
        if not self._judge.stands(lasting(self._moves)):
            return "failed", "what was done did not stay", ""
        return "succeeded", "", ""

    def _by_model(self) -> None:
        eyes = Eyes(renderer(), self._world, default_camera())
        follower = Follower(
            self._world,
            planner(),
            eyes,
            model(),
            mark=self._mark,
            begin=self._begin,
            end=self._end,
        )
        self.performed = follower.performed
        follower.follow(self._drawn.sentence)

    def _by_truth(self) -> None:
        for index, move in enumerate(self._moves):
            goal = self._begin(index)
            name = _name(move.moved + 1)
            self.performed.append(
                perform(
                    self._world,
                    planner(),
                    self._true_objects,
                    name,
                    goal,
                    self._mark,
                    keep=self._meant(),
                )
            )
            self._end(index)

    def _begin(self, index: int) -> Pose:
        self._reached = len(self.performed)
        # A sentence of which more steps were understood is judged by its last one.
        return self._judge.begin(self._moves[min(index, len(self._moves) - 1)])

    def _end(self, index: int) -> None:
        reached = self.performed[self._reached :]
        verdict = self._judge.end([place for done in reached for _, place in done.cleared])
        # What was refused has not begun.
        if verdict.seconds > 0:
            self.verdicts.append(verdict)

    def _meant(self) -> set[str]:
        return {_name(index + 1) for move in self._moves for index in (move.moved, move.reference)}

    def _true_objects(self) -> dict[str, Cuboid]:
        return {
            _name(placed.id): Cuboid(placed.pose, placed.block.edges_m)
            for placed in self._world.placed()
        }


def lasting(moves: Sequence[Move]) -> list[Move]:
    """The moves of whose blocks no later one moves any."""
    return [
        move
        for index, move in enumerate(moves)
        if not {move.moved, move.reference} & {later.moved for later in moves[index + 1 :]}
    ]


def _name(number: int) -> str:
    return f"object {number}"


@lru_cache(maxsize=1)
def renderer() -> Renderer:
    """This process's."""
    return open_renderer()


@lru_cache(maxsize=1)
def model() -> nsrm.Model:
    """The one that is built in."""
    return nsrm.Model.pretrained()


@lru_cache(maxsize=1)
def planner() -> Planner:
    """This process's."""
    return Planner()
