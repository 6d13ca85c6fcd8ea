"""Runs one episode: the model plans, the arm executes, and the ground truth judges.

The arm has only images and its joints; only the judge reads the ground truth."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from nsrm_harness import domain as domains
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
from nsrm_harness.evaluation.manipulation_trials.rows import TrialRow, draw
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.retries import ExecutionOptions, reach_sub_goal
from nsrm_harness.perception.observer import Observer
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.simulated_camera import SimulatedCamera


def run(
    row: TrialRow,
    seed: int,
    index: int,
    films: Path | None = None,
    domain: Domain | None = None,
) -> EpisodeResult:
    """Runs one episode, with the same result in any process.

    * `films`: folder for `film.gif` and `strip.png`
    * `domain`: by default the paper's; a worker in a cluster does not have its file
    """
    drawn = draw(row, generator(seed, f"arm_{row.name}", index), domain or domains.load())
    with closing(ArmWorld()) as world:
        kind = _ByTruth if row.is_control else _ByModel
        return kind(world, drawn, films).carry_out(row.name, index)


class _ByModel(TrialEpisode):
    """An episode in which the model plans from images."""

    def _observer(self) -> Observer:
        return Observer(SimulatedCamera(renderer(), self._world, default_camera()))

    def _aside(self) -> list[Pose]:
        return [place for done in self._reached_now() for place in done.aside]

    def _followed(self) -> EpisodeEnd:
        for verdict in self._verdicts:
            if not verdict.is_as_said:
                why = f"step {verdict.step + 1} is not done as said ({verdict})"
                return EpisodeEnd("failed", why)
        if not self._judge.stands(lasting(self._moves)):
            return EpisodeEnd("failed", "what was done did not stay")
        return EpisodeEnd("succeeded")


class _ByTruth(_ByModel):
    """An episode in which the arm is given the true poses and sub-goals."""

    def _follow(self) -> None:
        for index, move in enumerate(self._moves):
            goal = self._begin(index)
            self._performed.append(
                reach_sub_goal(
                    self._world,
                    planner(),
                    self._true_objects,
                    _name(move.moved + 1),
                    goal,
                    ExecutionOptions(keep=self._kept(index), mark=self._mark),
                )
            )
            self._end(index)

    def _kept(self, index: int) -> set[str]:
        """The objects of the steps so far; those that only later steps name may be moved aside."""
        moves = self._moves[: index + 1]
        return {_name(block + 1) for move in moves for block in (move.moved, move.reference)}

    def _true_objects(self) -> dict[str, Cuboid]:
        return {
            _name(placed.id): Cuboid(placed.pose, placed.block.edges_m)
            for placed in self._world.placed()
        }


def _name(number: int) -> str:
    return f"object {number}"
