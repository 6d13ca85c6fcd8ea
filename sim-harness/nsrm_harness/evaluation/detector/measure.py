"""Measures the detector against the boxes of the segmentation mask."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from nsrm_harness.common.number_text import or_dash
from nsrm_harness.evaluation.detector.match import match, overlaps
from nsrm_harness.evaluation.detector.scenes import Picture
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.perception.detector import Detections, detect
from nsrm_harness.perception.relief import PerceptionError
from nsrm_harness.visualization.pictures import BoxMark, annotate, side_by_side

IOU_LOOSE = 0.5
IOU_STRICT = 0.75
#: Number of scenes that are drawn.
DRAWN = 3


@dataclass(frozen=True)
class Measure:
    """Figures over all scenes; shares and overlaps in 0..1. Undefined figures are None: recall
    without objects, precision without detections, the others without a detection matched at 0.5."""

    scenes: int
    objects: int
    detections: int
    recall_50: float | None
    precision_50: float | None
    recall_75: float | None
    precision_75: float | None
    mean_iou: float | None
    """Over the detections matched at 0.5, like the errors."""
    depth_error_m: float | None
    """Mean difference of the mean depths."""
    place_error_m: float | None
    """Mean distance of the boxes' centres, back-projected at the mean depths."""
    place_error_p95_m: float | None
    scene_ms: float
    """Median processor time of a detection, on one core."""

    def as_json(self) -> dict[str, Any]:
        """The figures by name."""
        return asdict(self)

    def __str__(self) -> str:
        recall_50, precision_50, recall_75, precision_75, mean_iou = (
            or_dash(share, ".4f")
            for share in (
                self.recall_50,
                self.precision_50,
                self.recall_75,
                self.precision_75,
                self.mean_iou,
            )
        )
        depth, place, place_p95 = (
            or_dash(error_m, ".2f", times=1000, unit=" mm")
            for error_m in (self.depth_error_m, self.place_error_m, self.place_error_p95_m)
        )
        return (
            f"{self.scenes} scenes, {self.objects} objects, {self.detections} detections\n"
            f"IoU 0.50: recall {recall_50}, precision {precision_50}\n"
            f"IoU 0.75: recall {recall_75}, precision {precision_75}\n"
            f"mean IoU {mean_iou}, depth error {depth}, position error {place} (p95 {place_p95})\n"
            f"{self.scene_ms:.1f} ms per scene"
        )


@dataclass(frozen=True, eq=False)
class JudgedPicture:
    """An image, its detections, and the smallest overlap of a true or detected box with its best
    partner."""

    picture: Picture
    found: Detections
    worst: float


def measure(pictures: Iterable[Picture]) -> tuple[Measure, list[JudgedPicture]]:
    """Runs the detector on every image; also returns the `DRAWN` worst ones, worst first.

    Raises `PerceptionError` if the detector does, and if there are no images.
    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return _measure(pictures)
    finally:
        cv2.setNumThreads(threads)


def _measure(pictures: Iterable[Picture]) -> tuple[Measure, list[JudgedPicture]]:
    worst: list[JudgedPicture] = []
    objects = detections = 0
    seconds: list[float] = []
    ious: list[float] = []
    strict = 0
    depth_errors: list[float] = []
    place_errors: list[float] = []
    for picture in pictures:
        begun = time.process_time()
        found = detect(picture.image, picture.depth, picture.camera)
        seconds.append(time.process_time() - begun)
        objects += len(picture.boxes)
        detections += len(found)
        overlap = overlaps(found.boxes, picture.boxes)
        strict += int(np.count_nonzero(match(found.boxes, picture.boxes, IOU_STRICT) >= 0))
        for row, true in enumerate(match(found.boxes, picture.boxes, IOU_LOOSE)):
            if true < 0:
                continue
            ious.append(float(overlap[row, true]))
            depth_errors.append(abs(float(found.depths[row] - picture.depths[true])))
            here = _place(picture.camera, found.boxes[row], float(found.depths[row]))
            there = _place(picture.camera, picture.boxes[true], float(picture.depths[true]))
            place_errors.append(float(np.linalg.norm(here - there)))
        best = [part.max(initial=0.0) for part in (*overlap, *overlap.T)]
        worst.append(JudgedPicture(picture, found, float(min(best, default=1.0))))
        worst = sorted(worst, key=lambda judged: judged.worst)[:DRAWN]
    if not seconds:
        raise PerceptionError("no scenes to measure on")
    return (
        Measure(
            scenes=len(seconds),
            objects=objects,
            detections=detections,
            recall_50=_share(len(ious), objects),
            precision_50=_share(len(ious), detections),
            recall_75=_share(strict, objects),
            precision_75=_share(strict, detections),
            mean_iou=float(np.mean(ious)) if ious else None,
            depth_error_m=float(np.mean(depth_errors)) if ious else None,
            place_error_m=float(np.mean(place_errors)) if ious else None,
            place_error_p95_m=float(np.percentile(place_errors, 95)) if ious else None,
            scene_ms=1000 * float(np.median(seconds)),
        ),
        worst,
    )


def _share(count: int, whole: int) -> float | None:
    return count / whole if whole else None


def _place(camera: Camera, box: NDArray[np.float32], depth_m: float) -> NDArray[np.float64]:
    """The centre of the box at this depth, in the world, metres."""
    x1, y1, x2, y2 = (float(value) for value in box)
    column, row = (x1 + x2) / 2 * camera.width, (y1 + y2) / 2 * camera.height
    return camera.back_project((column, row, depth_m))


def draw(judged: list[JudgedPicture]) -> Image.Image:
    """Draws the images side by side with numbered detections in the objects' mean colours."""
    drawings, titles = [], []
    for each in judged:
        marks = []
        for row, box in enumerate(each.found.boxes):
            x1, y1, x2, y2 = (float(value) for value in box)
            own = each.picture.image[each.found.labels == row + 1]
            red, green, blue = (float(value) / 255 for value in own.mean(axis=0))
            marks.append(BoxMark((x1, y1, x2, y2), str(row + 1), (red, green, blue)))
        drawings.append(annotate(each.picture.image, marks))
        titles.append(
            f"{len(each.found)} of {len(each.picture.boxes)} found, least overlap {each.worst:.2f}"
        )
    return side_by_side(drawings, titles)
