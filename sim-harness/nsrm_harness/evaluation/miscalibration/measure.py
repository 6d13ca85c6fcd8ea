"""Measures how often the core refuses calibrated scenes, and how often it finds each fault."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import nsrm
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.detector.scenes import Picture
from nsrm_harness.evaluation.miscalibration.faults import FAULTS, Fault
from nsrm_harness.evaluation.miscalibration.scenes import KINDS, SceneKind, scenes
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.perception.detector import detect
from nsrm_harness.perception.relief import PerceptionError

EMBEDDING = 64
LEAST = 2
"""Smallest number of objects in a scene for planning."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The core's input for a scene: `boxes` `[n, 4]`, `depths` `[n]`."""

    boxes: NDArray[np.float32]
    depths: NDArray[np.float32]
    camera: Camera

    def refusal(self, model: nsrm.Model, fault: Fault) -> nsrm.Refused | None:
        """The core's refusal of the scene with a fault in the camera, if it refuses."""
        count = len(self.boxes)
        scene = model.scene_from_embeddings(
            list(range(1, count + 1)),
            self.boxes,
            np.float32(fault.depth_scale) * self.depths,
            np.zeros((count, EMBEDDING), np.float32),
            nsrm.Camera(**asdict(fault.change(self.camera))),
        )
        try:
            model.check(scene)
        except nsrm.Refused as refusal:
            return refusal
        return None


@dataclass(frozen=True)
class MiscalibrationRow:
    """Scenes of one kind with one fault; `boxes`: source of the boxes, "mask" or "detector".

    `known`: number refused with the fault's own cause; None if it has none.
    """

    kind: str
    boxes: str
    fault: str
    scenes: int
    refused: int
    known: int | None


@dataclass(frozen=True)
class MiscalibrationReport:
    """All rows, grouped by kind."""

    rows: tuple[MiscalibrationRow, ...]

    def as_json(self) -> list[dict[str, Any]]:
        """The rows by name."""
        return [asdict(row) for row in self.rows]

    def share(self, fault: str, boxes: str | None = None) -> float:
        """Share of refused scenes over all kinds."""
        chosen = [row for row in self.rows if row.fault == fault and boxes in (None, row.boxes)]
        return sum(row.refused for row in chosen) / sum(row.scenes for row in chosen)

    def __str__(self) -> str:
        lines = ["| calibrated scenes | boxes | scenes | refused |", "|---|---|---:|---:|"]
        without = [row for row in self.rows if row.fault == FAULTS[0].name]
        lines += [f"| {row.kind} | {row.boxes} | {row.scenes} | {row.refused} |" for row in without]
        lines += ["", "| fault | refused | recognised |", "|---|---:|---:|"]
        for fault in FAULTS[1:]:
            known = "-" if fault.cause is None else f"{100 * self._known(fault.name):.1f} %"
            lines.append(f"| {fault.name} | {100 * self.share(fault.name):.1f} % | {known} |")
        return "\n".join(lines)

    def _known(self, fault: str) -> float:
        chosen = [row for row in self.rows if row.fault == fault]
        return sum(row.known or 0 for row in chosen) / sum(row.scenes for row in chosen)


def measure(
    model: nsrm.Model,
    domain: Domain,
    count: int,
    seed: int,
    kinds: Sequence[SceneKind] = KINDS,
    report: Callable[[], object] = lambda: None,
) -> MiscalibrationReport:
    """Measures with `count` scenes of each kind; calls `report` after each.

    The detector uses the calibrated camera. Raises `HarnessError` if no scene of a kind can be
    used.
    """
    rows: list[MiscalibrationRow] = []
    for kind in kinds:
        seen: dict[str, list[Seen]] = {"mask": [], "detector": []}
        for picture in scenes(kind, domain, count, seed):
            seen["mask"] += _usable(picture.boxes, picture.depths, picture.camera)
            seen["detector"] += _detected(picture)
            report()
        for boxes, observed in seen.items():
            if not observed:
                raise HarnessError(
                    f"{kind.name}: none of {count} scenes can be used: use a larger --count"
                )
            rows += [_row(model, kind, boxes, observed, fault) for fault in FAULTS]
    return MiscalibrationReport(tuple(rows))


def _row(
    model: nsrm.Model, kind: SceneKind, boxes: str, seen: Iterable[Seen], fault: Fault
) -> MiscalibrationRow:
    causes: Counter[str | None] = Counter()
    scenes = 0
    for each in seen:
        scenes += 1
        if (refusal := each.refusal(model, fault)) is not None:
            causes[refusal.details["cause"]] += 1
    known = None if fault.cause is None else causes[fault.cause]
    return MiscalibrationRow(kind.name, boxes, fault.name, scenes, causes.total(), known)


def _detected(picture: Picture) -> list[Seen]:
    """The detections, if the detector can use the image."""
    try:
        found = detect(picture.image, picture.depth, picture.camera)
    except PerceptionError:
        return []
    return _usable(found.boxes, found.depths, picture.camera)


def _usable(boxes: NDArray[np.float32], depths: NDArray[np.float32], camera: Camera) -> list[Seen]:
    return [Seen(boxes, depths, camera)] if LEAST <= len(boxes) <= nsrm.MAX_OBJECTS else []
