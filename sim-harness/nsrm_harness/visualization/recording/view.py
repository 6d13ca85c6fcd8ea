"""Records the camera's images, and the groundings of a sentence in them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import nsrm
import numpy as np
import rerun as rr
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import FAR_M, NEAR_M, Camera
from nsrm_harness.perception.observer import Observation
from nsrm_harness.perception.relief import measurements
from nsrm_harness.visualization.recording.scene import RecordedScene
from nsrm_harness.visualization.recording.shapes import RGB, boxes, frame
from nsrm_harness.visualization.recording.timeline import Log

CAMERA = "world/camera"
PICTURE, DEPTH, BOXES = f"{CAMERA}/rgb", f"{CAMERA}/depth", f"{CAMERA}/boxes"
GROUNDINGS_2D, GROUNDINGS_3D = f"{CAMERA}/groundings", "world/groundings"

PNG = "image/png"
DEPTH_UNITS = 10_000
"""Units per metre in the depth image: 16 bits per pixel, tenths of millimetres."""
PLANE_M = 0.2
"""Distance from the camera at which the viewer shows its image."""
MOVES, REFERS_TO = "moves", "refers to"
MOVED_RGB: RGB = (1.0, 0.85, 0.0)
"""Colour of objects that any step moves,"""
REFERENCE_RGB: RGB = (0.0, 0.85, 1.0)
"""and of objects that steps only refer to."""


def depth_units(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """A depth image in `DEPTH_UNITS`: 0 where nothing was measured, the maximum where it is out of
    range."""
    units = measurements(depth) * DEPTH_UNITS
    return np.minimum(units.round(), np.iinfo(np.uint16).max).astype(np.uint16)


class View:
    """Records images and what is found in them."""

    def __init__(self, log: Log, camera: Camera, scene: RecordedScene) -> None:
        self._log, self._camera, self._scene = log, camera, scene
        log.always(
            CAMERA,
            frame(camera.pose),
            rr.Pinhole(
                width=camera.width,
                height=camera.height,
                focal_length=(camera.fx, camera.fy),
                principal_point=(camera.cx, camera.cy),
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=PLANE_M,
            ),
        )

    def show(self, sight: Observation) -> None:
        """Records an image, its depths and its detections."""
        rgb = _png(np.ascontiguousarray(sight.rgb[..., ::-1]))
        self._log.now(PICTURE, rr.EncodedImage(contents=rgb, media_type=PNG))
        self._log.now(
            DEPTH,
            rr.EncodedDepthImage(
                _png(depth_units(sight.depth)),
                media_type=PNG,
                meter=DEPTH_UNITS,
                depth_range=(NEAR_M * DEPTH_UNITS, FAR_M * DEPTH_UNITS),
            ),
        )
        numbers = list(sight.locations)
        self._log.now(
            BOXES,
            self._boxes(
                sight,
                numbers,
                [self._scene.name(number) for number in numbers],
                [self._scene.rgb(number) for number in numbers],
                show_labels=False,
            ),
        )

    def ground(self, sight: Observation, steps: Sequence[nsrm.PlannedStep]) -> None:
        """Records the objects that the steps move and refer to, in the image and in space."""
        roles: dict[int, list[str]] = {}
        for index, step in enumerate(steps, start=1):
            roles.setdefault(step.object_id, []).append(f"{index} {MOVES}")
            roles.setdefault(step.reference_id, []).append(f"{index} {REFERS_TO}")
        moved = {step.object_id for step in steps}
        for entity, shown, drawn in (
            (GROUNDINGS_2D, sight.locations, self._boxes),
            (GROUNDINGS_3D, sight.cuboids, _cuboids),
        ):
            numbers = [number for number in roles if number in shown]
            labels = [f"{number}: step {', '.join(roles[number])}" for number in numbers]
            colors = [MOVED_RGB if number in moved else REFERENCE_RGB for number in numbers]
            self._log.now(entity, drawn(sight, numbers, labels, colors))

    def _boxes(
        self,
        sight: Observation,
        numbers: Sequence[int],
        labels: Sequence[str],
        colors: Sequence[RGB],
        *,
        show_labels: bool = True,
    ) -> rr.Boxes2D:
        size_px = np.array([self._camera.width, self._camera.height] * 2)
        corners = [sight.locations[number][:4] * size_px for number in numbers]
        return rr.Boxes2D(
            array=np.reshape(corners, (-1, 4)),
            array_format=rr.Box2DFormat.XYXY,
            labels=labels,
            show_labels=show_labels,
            colors=np.reshape(colors, (-1, 3)),
        )


def _cuboids(
    sight: Observation, numbers: Sequence[int], labels: Sequence[str], colors: Sequence[RGB]
) -> rr.Boxes3D:
    return boxes([sight.cuboids[number] for number in numbers], labels, colors)


def _png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    return cv2.imencode(".png", image)[1].tobytes()
