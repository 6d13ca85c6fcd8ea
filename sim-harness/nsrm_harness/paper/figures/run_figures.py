"""Runs a figure: the model plans from sentence and image, the arm executes the sub-goals, and each
attempt at a step is judged."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import nsrm

from nsrm_harness import domain as domains
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.manipulation_trials.episode import lasting, model, planner, renderer
from nsrm_harness.evaluation.manipulation_trials.judge import PlacementJudge, PlacementVerdict
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.retries import ManipulationError, SubGoalReached
from nsrm_harness.manipulation.robot_interface import StuckError
from nsrm_harness.nodes.closed_loop import ClosedLoop
from nsrm_harness.paper.figures.scenes import Figure, FigureScene, draw
from nsrm_harness.paper.figures.sheet import Sheet
from nsrm_harness.perception.observer import (
    ObjectNames,
    Observation,
    Observer,
    name_objects,
    sub_goal,
)
from nsrm_harness.perception.relief import PerceptionError
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.simulated_camera import SimulatedCamera


@dataclass(frozen=True)
class CompletedStep:
    """A step that was executed.

    * `goal_off_m`: distance of the model's first sub-goal from the true one
    * `corrected_m`: distance of the model's sub-goal from where the arm planned to put the block
    """

    verdict: PlacementVerdict
    goal_off_m: float
    corrected_m: float
    tries: int

    def __str__(self) -> str:
        return f"{self.verdict}; the sub-goal was {1000 * self.goal_off_m:.1f} mm from it"


@dataclass(frozen=True)
class VariationResult:
    """How an episode ended.

    * `end`: "succeeded", "refused" (a reason was given instead of a step) or "failed"
    * `why`: the reason, or what did not succeed
    """

    figure: int
    variation: int
    seed: int
    sentence: str
    end: str
    why: str
    steps: tuple[CompletedStep, ...]


def run(
    figure: Figure,
    seed: int,
    variation: int,
    picture: Path | None = None,
    domain: Domain | None = None,
) -> VariationResult:
    """Runs a variation of a figure and draws it into `picture`, with the same result in any
    process.

    * `domain`: by default the paper's; a worker in a cluster does not have its file
    """
    domain = domain or domains.load()
    scene = draw(figure, domain, seed, variation)
    with closing(ArmWorld()) as world:
        world.spawn(scene.arrangement.blocks, scene.arrangement.poses)
        world.settle()
        episode = _Episode(world, scene, domain, Sheet(figure))
        end, why = episode.carry_out(figure.sentence)
    if picture is not None:
        episode.sheet.save(picture, "" if end == "succeeded" else f"{end}: {why}")
    return VariationResult(
        figure.number, variation, seed, figure.sentence, end, why, tuple(episode.done)
    )


class _Episode:
    def __init__(self, world: ArmWorld, scene: FigureScene, domain: Domain, sheet: Sheet) -> None:
        self._world, self._moves, self.sheet = world, scene.moves, sheet
        self._domain = domain
        self._judge = PlacementJudge(world, scene.arrangement.blocks)
        world.on_tick = self._judge.tick
        self._observer = Observer(SimulatedCamera(renderer(), world, default_camera()))
        self._number, self._has_reached = 0, False
        self.done: list[CompletedStep] = []

    def carry_out(self, sentence: str) -> tuple[str, str]:
        """Runs the sentence; returns how it ended, and why."""
        try:
            plan, known = self._plan(sentence)
        except nsrm.Refused as refusal:
            return "refused", f"model: {refusal}"
        except PerceptionError as error:
            return "failed", f"detector: {error}"
        if len(plan.steps) != len(self._moves):
            return "failed", f"model: {len(plan.steps)} steps instead of {len(self._moves)}"
        self._steps = plan.steps
        loop = ClosedLoop(
            self._world,
            planner(),
            self._observer,
            model(),
            known.spoken,
            looked=self._looked,
            begin=self._begin,
            reached=self._reached,
        )
        try:
            loop.follow(sentence)
        except (nsrm.Refused, RefusedError) as refusal:
            return "refused", f"arm, step {self._number}: {refusal}"
        except (ManipulationError, StuckError) as error:
            self.sheet.add_step(self._number, self._sight, "failed")
            return "failed", f"arm, step {self._number}: {error}"
        for number, done in enumerate(self.done, start=1):
            if not done.verdict.is_as_said:
                return "failed", f"attempt {number} at a step did not succeed: {done}"
        if not self._judge.stands(lasting(self._moves)):
            return "failed", "what was done did not stay"
        return "succeeded", ""

    def _plan(self, sentence: str) -> tuple[nsrm.Plan, ObjectNames]:
        sight = self._observer.look()
        known = name_objects(model(), self._domain, sight)
        self.sheet.add_scene(sight, known)
        plan = model().plan(sight.scene(model(), self._observer.camera), sentence)
        self.sheet.add_plan(plan)
        return plan, known

    def _looked(self, sight: Observation) -> None:
        self._sight = sight

    def _begin(self, index: int) -> None:
        # If replanning finds more steps than there are, the extra ones are judged as the last.
        number = min(index, len(self._moves) - 1) + 1
        # What failed and is tried again is one attempt.
        if self._has_reached or number != self._number:
            self._number, self._has_reached = number, False
            self._truth = self._judge.begin(self._moves[number - 1])

    def _reached(self, _index: int, performed: SubGoalReached) -> None:
        self._has_reached = True
        verdict = replace(self._judge.end(performed.aside), step=self._number - 1)
        goal_off_m = sub_goal(self._steps[self._number - 1]).distance_m(self._truth)
        self.done.append(CompletedStep(verdict, goal_off_m, performed.corrected_m, performed.tries))
        self.sheet.add_step(self._number, self._sight, f"{1000 * verdict.off_m:.1f} mm off")
