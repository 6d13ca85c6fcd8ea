"""Measures how the core plans through other cameras than that of the model's training."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import nsrm
import numpy as np
from scipy.spatial.transform import Rotation

from nsrm_harness.data.moves import Move, target
from nsrm_harness.data.programs import Descriptions, sample_blocks, unique_descriptions
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.domain.program import Step
from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.geometry.pose import Pose, Vector3
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.layout import WORK_SPACE, LayoutError, sample_layout
from nsrm_harness.simulation.render import Light, open_renderer
from nsrm_harness.simulation.segmentation import SegmentedImage, render_segmented
from nsrm_harness.simulation.world import World

MIDDLE = (0.5, 0.0, 0.0)
"""What all cameras look at: the middle of the work space."""
BLOCKS = 5
MAX_DRAWS = 100


@dataclass(frozen=True)
class CameraPlacement:
    """Where a camera stands.

    * `azimuth`: to which side of the table, degrees; at 0 opposite the robot
    * `elevation`: above the horizon, degrees
    * `distance_m`: from the middle of the work space
    * `width`, `height`, `focal_px`: pixels
    """

    azimuth: float = 0.0
    elevation: float = 40.0
    distance_m: float = 1.25
    width: int = 640
    height: int = 480
    focal_px: float = 900.0

    def camera(self) -> Camera:
        """The camera."""
        around, above = math.radians(self.azimuth), math.radians(self.elevation)
        x, y, z = MIDDLE
        position = (
            x + self.distance_m * math.cos(above) * math.cos(around),
            y + self.distance_m * math.cos(above) * math.sin(around),
            z + self.distance_m * math.sin(above),
        )
        return Camera.looking_at(
            position, MIDDLE, width=self.width, height=self.height, focal_px=self.focal_px
        )

    def __str__(self) -> str:
        return (
            f"azimuth {self.azimuth:.0f}°, elevation {self.elevation:.0f}°, "
            f"{self.distance_m:g} m, {self.width}×{self.height}, focal length "
            f"{self.focal_px:.0f} px"
        )


VIEWS = (
    None,
    CameraPlacement(),
    CameraPlacement(distance_m=0.8, focal_px=600.0),
    CameraPlacement(distance_m=1.7, focal_px=1250.0),
    CameraPlacement(width=320, height=240, focal_px=450.0),
    CameraPlacement(width=1280, height=960, focal_px=1800.0),
    CameraPlacement(elevation=25.0),
    CameraPlacement(elevation=35.0),
    CameraPlacement(elevation=60.0),
    CameraPlacement(elevation=75.0),
    CameraPlacement(azimuth=30.0),
    CameraPlacement(azimuth=-90.0),
    CameraPlacement(azimuth=180.0, elevation=60.0, distance_m=1.0, focal_px=720.0),
)
"""None is the camera of the training."""


@dataclass(frozen=True)
class ViewRow:
    """Sentences of one step through one camera.

    * `refused`: not planned
    * `wrong`: planned with another object or reference
    * `p50_mm`, `p95_mm`: distance of the sub-goals of the others from where the demonstrator would
      put the object; None if there are none
    """

    view: str
    sentences: int
    refused: int
    wrong: int
    p50_mm: float | None
    p95_mm: float | None


@dataclass(frozen=True)
class SceneSentence:
    """A sentence about a scene, and what it means there."""

    sentence: str
    moved: int
    reference: int
    target: Vector3


def measure(
    model: nsrm.Model,
    domain: Domain,
    count: int,
    seed: int,
    views: Sequence[CameraPlacement | None] = VIEWS,
    report: Callable[[], object] = lambda: None,
) -> list[ViewRow]:
    """`count` sentences through each camera; calls `report` after each. The blocks stand square to
    the table."""
    drawing = open_renderer("auto")
    rows = []
    with World() as world:
        for view in views:
            camera = view.camera() if view else default_camera()
            errors: list[float] = []
            refused = wrong = 0
            for index in range(count):
                rng = generator(seed, "viewpoints", index)
                task, seen = _scene(rng, domain, world, camera, drawing)
                plan = _plan(model, task, seen, camera)
                if plan is None:
                    refused += 1
                elif (plan.object_id, plan.reference_id) != (task.moved, task.reference):
                    wrong += 1
                else:
                    errors.append(math.dist(plan.position, task.target))
                report()
            name = str(view) if view else "the camera of the training"
            rows.append(ViewRow(name, count, refused, wrong, *_quantiles_mm(errors)))
    drawing.close()
    return rows


def table(rows: Sequence[ViewRow]) -> str:
    """The rows as Markdown."""
    lines = [
        "| camera | sentences | refused | other objects | sub-goals off by, p50; p95 |",
        "|---|---:|---:|---:|---:|",
    ]
    for row in rows:
        errors = [f"{error:.1f}" for error in (row.p50_mm, row.p95_mm) if error is not None]
        off = f"{'; '.join(errors)} mm" if errors else "-"
        lines.append(f"| {row.view} | {row.sentences} | {row.refused} | {row.wrong} | {off} |")
    return "\n".join(lines)


def as_json(rows: Sequence[ViewRow]) -> list[dict[str, Any]]:
    """The rows by name."""
    return [asdict(row) for row in rows]


def _quantiles_mm(errors_m: Sequence[float]) -> tuple[float, float] | tuple[None, None]:
    if not errors_m:
        return None, None
    p50, p95 = np.quantile(errors_m, [0.5, 0.95])
    return 1e3 * float(p50), 1e3 * float(p95)


def _scene(
    rng: np.random.Generator, domain: Domain, world: World, camera: Camera, drawing: Any
) -> tuple[SceneSentence, SegmentedImage]:
    """A scene in which both blocks of a sentence are seen completely."""
    while True:
        blocks = sample_blocks(rng, domain, BLOCKS)
        try:
            poses = sample_layout(rng, blocks, max_yaw_rad=0.0)
        except LayoutError:
            continue
        world.reset()
        world.spawn(blocks, poses)
        world.settle()
        seen = render_segmented(drawing, world, camera, Light.sample(rng))
        known = world.poses()
        whole = _inside(seen)
        task = _task(rng, domain, blocks, list(known.values()), list(known), whole, camera)
        if task is not None:
            return task, seen


def _inside(seen: SegmentedImage) -> set[int]:
    """Ids of the objects that do not touch the edge of the image."""
    height, width, _ = seen.rgb.shape
    margin = 1.5 / np.array([width, height, width, height])
    at_edge = ((seen.boxes <= margin) | (seen.boxes >= 1 - margin)).any(axis=1)
    return {int(each) for each in np.asarray(seen.ids)[~at_edge]}


def _task(
    rng: np.random.Generator,
    domain: Domain,
    blocks: Sequence[Block],
    poses: Sequence[Pose],
    ids: Sequence[int],
    whole: set[int],
    camera: Camera,
) -> SceneSentence | None:
    """A sentence of one step whose target lies in the work space; None if none was found."""
    unique = unique_descriptions(domain, blocks, Descriptions(1, 2))
    turn = Rotation.from_euler("z", _azimuth(camera) - _azimuth(default_camera()))
    for _ in range(MAX_DRAWS):
        moved, reference = (int(index) for index in rng.permutation(len(blocks))[:2])
        action = domain.actions[rng.integers(len(domain.actions))]
        if not {ids[moved], ids[reference]} <= whole or not (unique[moved] and unique[reference]):
            continue
        place = target(Move(action, moved, reference), blocks, poses).position
        base = np.array(poses[reference].position)
        # The viewer's left.
        aside = turn.apply([*(np.array(place)[:2] - base[:2]), 0.0])
        x, y, _ = base + aside
        place = (float(x), float(y), place[2])
        if not WORK_SPACE.contains(place):
            continue
        said = [list(unique[index].values())[-1] for index in (moved, reference)]
        step = Step(action.name, said[0], said[1])
        sentence = Grammar(domain).plain((step,))
        return SceneSentence(sentence, ids[moved], ids[reference], place)
    return None


def _azimuth(camera: Camera) -> float:
    """Of the horizontal direction in which it looks, radians."""
    x, y, _ = camera.pose.rotation()[:, 2]
    return math.atan2(y, x)


def _plan(
    model: nsrm.Model, task: SceneSentence, seen: SegmentedImage, camera: Camera
) -> nsrm.PlannedStep | None:
    """The planned step; None if the sentence is refused."""
    scene = model.observe(
        seen.rgb, list(seen.ids), seen.boxes, seen.depths, nsrm.Camera(**asdict(camera))
    )
    try:
        (step,) = model.plan(scene, task.sentence).steps
    except nsrm.Refused:
        return None
    return step
