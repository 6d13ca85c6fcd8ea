"""Runs the demonstration, from seed and sentence to pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import nsrm
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from nsrm_harness.common.json_text import json_text
from nsrm_harness.data.tabletop import tabletop
from nsrm_harness.demo import report
from nsrm_harness.demo.carry_out import Goal, carry, set_down
from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.perception.observer import (
    ObjectNames,
    Observation,
    Observer,
    name_objects,
    sub_goal,
)
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera
from nsrm_harness.simulation.world import World
from nsrm_harness.visualization.demo_listener import DemoListener, StepResult, Stopped
from nsrm_harness.visualization.film import Film
from nsrm_harness.visualization.pictures import Arrow, BoxMark, Rect, Tie, annotate, side_by_side
from nsrm_harness.visualization.prediction import cut_out, predicted_scene

FILES = ("initial.png", "predicted.png", "result.png", "overview.png", "strip.png", "film.gif")
"""All files that a demonstration may write, in addition to the scene."""


@dataclass(frozen=True)
class Shown:
    """The result of a demonstration."""

    text: str
    document: dict[str, Any]
    pictures: tuple[Path, ...]
    #: Why the sentence was not carried out; None if it was.
    refusal: nsrm.Refused | Stopped | None


def show(
    domain: Domain,
    renderer: Renderer,
    seed: int,
    sentence: str | None,
    out: Path,
    *,
    with_arm: bool = True,
    onlooker: DemoListener | None = None,
) -> Shown:
    """Draws the scene of `seed`, plans `sentence` (by default one that fits), lets the arm execute
    the plan (or, without the arm, puts the blocks at their sub-goals), and writes pictures and
    `scene.json` to `out`.

    * `onlooker`: notified of all events
    """
    out.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        (out / name).unlink(missing_ok=True)
    onlooker = onlooker or DemoListener()
    model = nsrm.Model.pretrained()
    camera = default_camera()
    stage = tabletop(domain, seed)
    sentence = stage.sentence if sentence is None else sentence
    with ArmWorld() if with_arm else World() as world:
        background = renderer.render(world, camera, Light()).rgb
        world.spawn(stage.arrangement.blocks, stage.arrangement.poses)
        world.settle()
        observer = Observer(SimulatedCamera(renderer, world, camera))
        sight = observer.look()
        initial = _InitialScene(sentence, background, sight, name_objects(model, domain, sight))
        onlooker.begin(world, camera, initial.known, sentence)
        onlooker.looked(sight)
        _write_scene(out, sight, camera)
        heading = (
            f'sentence  "{sentence}"\n'
            f"scene     seed {seed}, {len(sight.locations)} objects found by the detector; "
            f"rendered by {renderer.name}"
        )
        document: dict[str, Any] = {"sentence": sentence, "seed": seed}
        try:
            plan = model.plan(sight.scene(model, camera), sentence)
        except nsrm.Refused as refusal:
            onlooker.refused(refusal)
            onlooker.end()
            pictures = {"initial": initial.refused_picture(refusal)}
            document |= {"refused": _refused_as_json(refusal)}
            return Shown(heading, document, _save(out, pictures), refusal)
        onlooker.planned(plan)
        films: list[Path] = []
        outcomes: Sequence[StepResult]
        if isinstance(world, ArmWorld):
            film = Film(world, renderer)
            listener = _Filming(film, onlooker)
            outcomes = carry(world, observer, model, sentence, initial.known.spoken, listener)
            films = film.save(out)
        else:
            goals: list[Goal] = [(step.object_id, sub_goal(step)) for step in plan.steps]
            outcomes = set_down(world, sight, goals, onlooker.ended)
        result = observer.look()
        onlooker.looked(result)
        onlooker.end()
    return Shown(
        f"{heading}\n{report.as_text(plan, initial.known.words, outcomes)}",
        document | report.as_json(plan, outcomes),
        (*_save(out, _pictures(initial, plan, outcomes, result)), *films),
        next((outcome for outcome in outcomes if isinstance(outcome, Stopped)), None),
    )


class _Filming(DemoListener):
    """Passes the events of an execution on, and has the film mark them."""

    def __init__(self, film: Film, onlooker: DemoListener) -> None:
        self._film, self._onlooker = film, onlooker

    def looked(self, sight: Observation) -> None:
        """The scene was observed."""
        self._onlooker.looked(sight)

    def mark(self, event: str) -> None:
        """The arm has just done `event`."""
        self._film.mark(event)
        self._onlooker.mark(event)

    def ended(self, index: int, outcome: StepResult) -> None:
        """A step has ended."""
        self._onlooker.ended(index, outcome)


@dataclass(frozen=True, eq=False)
class _InitialScene:
    """The scene before anything moves.

    * `background`: `uint8 [H, W, 3]`, the image without the blocks
    """

    sentence: str
    background: NDArray[np.uint8]
    sight: Observation
    known: ObjectNames

    def refused_picture(self, refusal: nsrm.Refused) -> Image.Image:
        """The objects that were found, and why there is no plan."""
        caption = f"“{self.sentence}”\nRefused: {refusal}"
        return annotate(self.sight.rgb, _marks(self.sight, self.known), caption=caption)


def _refused_as_json(refusal: nsrm.Refused) -> dict[str, Any]:
    return {"kind": refusal.kind, "message": str(refusal), **refusal.details}


def _pictures(
    scene: _InitialScene,
    plan: nsrm.Plan,
    outcomes: Sequence[StepResult],
    result: Observation,
) -> dict[str, Image.Image]:
    sight, known = scene.sight, scene.known
    arrows: list[Arrow] = []
    ties: list[Tie] = []
    locations = dict(sight.locations)
    for number, step in enumerate(plan.steps, start=1):
        for described in _chains(step):
            places = [_rect(locations[object_id]) for object_id in described]
            ties += [Tie(start, end) for start, end in pairwise(places)]
        arrows.append(Arrow(_rect(locations[step.object_id]), _rect(step.location), number))
        locations[step.object_id] = step.location
    moved = {step.object_id for step in plan.steps}
    cutouts = {number: cut_out(sight, number) for number in sight.locations}
    marks, caption = _marks(sight, known, plan), f"“{scene.sentence}”"
    initial = annotate(sight.rgb, marks, arrows, caption, ties)
    predicted = annotate(
        predicted_scene(scene.background, cutouts, locations),
        [_mark(known, number, locations[number]) for number in sorted(moved)],
        caption="\n".join(step.explanation for step in plan.steps),
    )
    final = annotate(
        result.rgb,
        [
            _mark(known, number, result.locations[number])
            for number in sorted(moved & set(result.locations))
        ],
        caption="\n".join(f"Step {i}: {outcome}." for i, outcome in enumerate(outcomes, start=1)),
    )
    overview = side_by_side(
        [initial, predicted, final],
        ["The scene and the chosen objects", "Predicted sub-goals", "Result"],
    )
    return {
        "initial": initial,
        "predicted": predicted,
        "result": final,
        "overview": overview,
    }


def _chains(step: nsrm.PlannedStep) -> tuple[list[int], list[int]]:
    """The object and the reference of a step, each followed by what its description relates it
    to."""
    return (
        [step.object_id, *step.object_anchor_ids],
        [step.reference_id, *step.reference_anchor_ids],
    )


def _marks(sight: Observation, known: ObjectNames, plan: nsrm.Plan | None = None) -> list[BoxMark]:
    steps = [] if plan is None else list(enumerate(plan.steps, start=1))
    return [
        BoxMark(
            _rect(location),
            f"{object_id} {known.words[object_id]}",
            known.colors[object_id],
            tuple(number for number, step in steps if step.object_id == object_id),
            tuple(number for number, step in steps if step.reference_id == object_id),
            tuple(
                number
                for number, step in steps
                if any(object_id in chain[1:] for chain in _chains(step))
            ),
        )
        for object_id, location in sight.locations.items()
    ]


def _mark(known: ObjectNames, number: int, location: np.ndarray) -> BoxMark:
    return BoxMark(_rect(location), f"{number} {known.words[number]}", known.colors[number])


def _write_scene(out: Path, sight: Observation, camera: Camera) -> None:
    """Writes the input for `nsrm plan --scene`: the same image, boxes and depths."""
    Image.fromarray(sight.rgb).save(out / "camera.png")
    document = {
        "schema": 1,
        "camera": asdict(camera),
        "image": "camera.png",
        "objects": [
            {"id": number, "box": location[:4].tolist(), "depth": float(location[4])}
            for number, location in sight.locations.items()
        ],
    }
    (out / "scene.json").write_text(json_text(document, indent=1) + "\n", encoding="utf-8")


def _save(out: Path, pictures: Mapping[str, Image.Image]) -> tuple[Path, ...]:
    paths = []
    for name, picture in pictures.items():
        paths.append(out / f"{name}.png")
        picture.save(paths[-1])
    return tuple(paths)


def _rect(box: np.ndarray) -> Rect:
    x1, y1, x2, y2 = (float(value) for value in box[:4])
    return (x1, y1, x2, y2)
