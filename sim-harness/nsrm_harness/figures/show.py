"""A figure carried out: the model plans from sentence and picture, the arm follows its sub-goals,
and each step is judged."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import nsrm

from nsrm_harness import domain as domains
from nsrm_harness.arm.perform import FailedError, perform
from nsrm_harness.arm.refused import RefusedError
from nsrm_harness.arm_trials.episode import model, planner, renderer
from nsrm_harness.arm_trials.judge import Judge, Verdict
from nsrm_harness.domain import Domain
from nsrm_harness.episodes.moves import Move
from nsrm_harness.figures.scenes import Figure, Scene, draw
from nsrm_harness.figures.sheet import Sheet
from nsrm_harness.perception.cuboids import Cuboid
from nsrm_harness.perception.relief import PerceptionError
from nsrm_harness.sight import Eyes, Sight, names, sub_goal
from nsrm_harness.world.arm_world import ArmWorld
from nsrm_harness.world.camera import default_camera


@dataclass(frozen=True)
class Done:
    """A step that was carried out.

    * `goal_off_m`: between the model's sub-goal and where the block is to be
    * `corrected_m`: between the model's sub-goal and where the arm meant to put the block
    """

    verdict: Verdict
    goal_off_m: float
    corrected_m: float
    tries: int

    def __str__(self) -> str:
        return f"{self.verdict}; the sub-goal was {1000 * self.goal_off_m:.1f} mm from it"


@dataclass(frozen=True)
class Ended:
    """How an episode ended.

    * `end`: "succeeded", "refused" (a reason was given in place of a step) or "failed"
    * `why`: the reason, or what was not as said
    """

    figure: int
    variation: int
    seed: int
    sentence: str
    end: str
    why: str
    steps: tuple[Done, ...]


def run(
    figure: Figure,
    seed: int,
    variation: int,
    picture: Path | None = None,
    domain: Domain | None = None,
) -> Ended:
    """Carries a variation of a figure out, and draws it into `picture`; the same in any
    process.

    * `domain`: the paper's if none is given; a cluster's worker has no file of it
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
    return Ended(figure.number, variation, seed, figure.sentence, end, why, tuple(episode.done))


class _Episode:
    def __init__(self, world: ArmWorld, scene: Scene, domain: Domain, sheet: Sheet) -> None:
        self._world, self._moves, self.sheet = world, scene.moves, sheet
        self._domain = domain
        self._judge = Judge(world, scene.arrangement.blocks)
        world.on_tick = self._judge.tick
        self._eyes = Eyes(renderer(), world, default_camera())
        self._names: dict[int, str] = {}
        self.done: list[Done] = []

    def carry_out(self, sentence: str) -> tuple[str, str]:
        """How it ends, and why."""
        try:
            plan = self._plan(sentence)
        except nsrm.Refused as refusal:
            return "refused", f"model: {refusal}"
        except PerceptionError as error:
            return "failed", f"detector: {error}"
        if len(plan.steps) != len(self._moves):
            return "failed", f"model: {len(plan.steps)} steps, but {len(self._moves)} were said"
        for number, (step, move) in enumerate(zip(plan.steps, self._moves, strict=True), start=1):
            try:
                self._step(number, step, move)
            except RefusedError as refusal:
                return "refused", f"arm, step {number}: {refusal}"
            except (FailedError, PerceptionError) as error:
                self.sheet.add_step(number, self._sight, "failed")
                return "failed", f"arm, step {number}: {error}"
            if not self.done[-1].verdict.is_as_said:
                return "failed", f"step {number} is not as said: {self.done[-1]}"
        return "succeeded", ""

    def _plan(self, sentence: str) -> nsrm.Plan:
        sight = self._look()
        known = names(model(), self._domain, sight)
        self._names = {number: f"object {number} ({it})" for number, it in known.words.items()}
        self.sheet.add_scene(sight, known)
        plan = model().plan(sight.scene(model(), self._eyes.camera), sentence)
        self.sheet.add_plan(plan)
        meant = {n for step in plan.steps for n in (step.object_id, step.reference_id)}
        self._keep = {self._names[number] for number in meant}
        return plan

    def _step(self, number: int, step: nsrm.PlannedStep, move: Move) -> None:
        goal, truth = sub_goal(step), self._judge.begin(move)
        name = self._names[step.object_id]
        performed = perform(self._world, planner(), self._objects, name, goal, keep=self._keep)
        verdict = self._judge.end([place for _, place in performed.cleared])
        self.done.append(
            Done(verdict, goal.distance_m(truth), performed.corrected_m, performed.tries)
        )
        self.sheet.add_step(number, self._sight, f"{1000 * verdict.off_m:.1f} mm off")

    def _look(self) -> Sight:
        self._sight = self._eyes.look()
        return self._sight

    def _objects(self) -> dict[str, Cuboid]:
        return {
            # One that was not there before has no name yet.
            self._names.get(number, f"object {number}"): cuboid
            for number, cuboid in self._look().cuboids.items()
        }
