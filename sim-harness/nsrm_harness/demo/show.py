"""The demonstration from seed and sentence to pictures."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import nsrm
import numpy as np
from PIL import Image

from nsrm_harness.demo import report
from nsrm_harness.demo.outcome import Landing, carry_out
from nsrm_harness.demo.prediction import Location, cut_out, predicted_scene
from nsrm_harness.demo.tabletop import tabletop
from nsrm_harness.domain import Domain
from nsrm_harness.pictures import Arrow, BoxMark, Rect, annotate, side_by_side
from nsrm_harness.world.camera import (
    Camera,
    Observation,
    default_camera,
    located,
    observation,
)
from nsrm_harness.world.pose import Pose
from nsrm_harness.world.render import Frame, Light, Renderer
from nsrm_harness.world.world import World


@dataclass(frozen=True)
class Seen:
    """The scene as camera and model see it; nothing here comes from the simulator."""

    observation: Observation
    frame: Frame
    #: The same view without objects.
    background: np.ndarray
    #: The likeliest value of each attribute type, by object.
    names: dict[int, str]
    colors: dict[int, tuple[float, float, float]]

    @property
    def locations(self) -> dict[int, Location]:
        """Box and mean depth by object."""
        rows = np.column_stack([self.observation.boxes, self.observation.depths])
        return dict(zip(self.observation.ids, rows, strict=True))


@dataclass(frozen=True)
class Shown:
    """What a demonstration came to."""

    text: str
    document: dict[str, Any]
    pictures: tuple[Path, ...]
    #: Why the sentence was not obeyed; None when it was.
    refusal: nsrm.Refused | None


def show(domain: Domain, renderer: Renderer, seed: int, sentence: str | None, out: Path) -> Shown:
    """Draws the scene of `seed`, plans `sentence` (or one that fits) in it, puts the
    blocks where the plan says, and writes pictures and `scene.json` into `out`."""
    out.mkdir(parents=True, exist_ok=True)
    model = nsrm.Model.pretrained()
    camera = default_camera()
    stage = tabletop(domain, seed)
    sentence = stage.sentence if sentence is None else sentence
    with World() as world:
        background = renderer.render(world, camera, Light()).rgb
        world.spawn(stage.arrangement.blocks, stage.arrangement.poses)
        world.settle()
        seen = _look(model, domain, renderer.render(world, camera, Light()), background)
        scene = model.observe(
            seen.observation.rgb,
            list(seen.observation.ids),
            seen.observation.boxes,
            seen.observation.depths,
            nsrm.Camera(**asdict(camera)),
        )
        _write_scene(out, seen.observation, camera)
        heading = (
            f'sentence  "{sentence}"\n'
            f"scene     seed {seed}, {len(seen.observation.ids)} objects; boxes from the "
            f"segmentation mask, which stands in for a detector; drawn by {renderer.name}"
        )
        document: dict[str, Any] = {"sentence": sentence, "seed": seed}
        try:
            plan = model.plan(scene, sentence)
        except nsrm.Refused as refusal:
            refused = {"kind": refusal.kind, "message": str(refusal), **refusal.details}
            picture = annotate(
                seen.observation.rgb, _marks(seen), caption=f"“{sentence}”\nRefused: {refusal}"
            )
            paths = _save(out, {"initial": picture})
            return Shown(heading, document | {"refused": refused}, paths, refusal)
        goals = [
            (step.object_id, Pose(_three(step.position), _four(step.orientation)))
            for step in plan.steps
        ]
        landings = carry_out(world, goals)
        result = renderer.render(world, camera, Light())
    paths = _save(out, _pictures(sentence, seen, plan, landings, result))
    text = f"{heading}\n{report.as_text(plan, seen.names, landings)}"
    return Shown(text, document | report.as_json(plan, landings), paths, None)


def _look(model: nsrm.Model, domain: Domain, frame: Frame, background: np.ndarray) -> Seen:
    seen = observation(frame)
    names: dict[int, str] = {}
    colors: dict[int, tuple[float, float, float]] = {}
    for object_id, box in zip(seen.ids, seen.boxes, strict=True):
        similarities = model.similarities(model.encode_crop(nsrm.crop(seen.rgb, box)))
        values = [
            max(attribute.values, key=lambda value: similarities[value.name])
            for attribute in domain.attributes
        ]
        names[object_id] = " ".join(value.name for value in reversed(values))
        colors[object_id] = next(value.rgb for value in values if value.rgb is not None)
    return Seen(seen, frame, background, names, colors)


def _pictures(
    sentence: str,
    seen: Seen,
    plan: nsrm.Plan,
    landings: Sequence[Landing],
    result: Frame,
) -> dict[str, Image.Image]:
    arrows: list[Arrow] = []
    locations = seen.locations
    for number, step in enumerate(plan.steps, start=1):
        arrows.append(Arrow(_rect(locations[step.object_id]), _rect(step.location), number))
        locations[step.object_id] = step.location
    moved = {step.object_id for step in plan.steps}
    cutouts = {
        object_id: cut_out(seen.frame, location, object_id)
        for object_id, location in seen.locations.items()
    }
    initial = annotate(seen.observation.rgb, _marks(seen, plan), arrows, caption=f"“{sentence}”")
    predicted = annotate(
        predicted_scene(seen.background, cutouts, locations),
        [_mark(seen, object_id, locations[object_id]) for object_id in sorted(moved)],
        caption="\n".join(step.explanation for step in plan.steps),
    )
    reached = located(result)
    boxes = dict(zip(reached.ids, reached.boxes, strict=True))
    final = annotate(
        result.rgb,
        [_mark(seen, object_id, boxes[object_id]) for object_id in sorted(moved & set(boxes))],
        caption="\n".join(f"Step {i}: {landing}." for i, landing in enumerate(landings, start=1)),
    )
    overview = side_by_side(
        [initial, predicted, final],
        ["The scene, and what the model chose", "What the model predicts", "What physics leaves"],
    )
    return {
        "initial": initial,
        "predicted": predicted,
        "result": final,
        "overview": overview,
    }


def _marks(seen: Seen, plan: nsrm.Plan | None = None) -> list[BoxMark]:
    steps = [] if plan is None else list(enumerate(plan.steps, start=1))
    return [
        BoxMark(
            _rect(box),
            f"{object_id} {seen.names[object_id]}",
            seen.colors[object_id],
            tuple(number for number, step in steps if step.object_id == object_id),
            tuple(number for number, step in steps if step.reference_id == object_id),
        )
        for object_id, box in seen.locations.items()
    ]


def _mark(seen: Seen, object_id: int, box: np.ndarray) -> BoxMark:
    label = f"{object_id} {seen.names[object_id]}"
    return BoxMark(_rect(box), label, seen.colors[object_id])


def _write_scene(out: Path, seen: Observation, camera: Camera) -> None:
    """What `nsrm plan --scene` reads: the same picture, boxes and depths."""
    Image.fromarray(seen.rgb).save(out / "camera.png")
    rows = zip(seen.ids, seen.boxes.tolist(), seen.depths.tolist(), strict=True)
    document = {
        "schema": 1,
        "camera": asdict(camera),
        "image": "camera.png",
        "objects": [{"id": key, "box": box, "depth": depth} for key, box, depth in rows],
    }
    (out / "scene.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def _save(out: Path, pictures: Mapping[str, Image.Image]) -> tuple[Path, ...]:
    """Writes the pictures, and takes away those of an earlier run into the same folder."""
    for name in ("initial", "predicted", "result", "overview"):
        (out / f"{name}.png").unlink(missing_ok=True)
    paths = []
    for name, picture in pictures.items():
        paths.append(out / f"{name}.png")
        picture.save(paths[-1])
    return tuple(paths)


def _rect(box: np.ndarray) -> Rect:
    x1, y1, x2, y2 = (float(value) for value in box[:4])
    return (x1, y1, x2, y2)


def _three(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def _four(values: Sequence[float]) -> tuple[float, float, float, float]:
    x, y, z, w = (float(value) for value in values)
    return (x, y, z, w)
