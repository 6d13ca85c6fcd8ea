"""Converts poses and cuboids to Rerun archetypes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose

RGB = tuple[float, float, float]
"""Each in 0..1."""


def frame(pose: Pose) -> rr.Transform3D:
    """The transform of everything below an entity."""
    orientation = rr.Quaternion(xyzw=pose.orientation)
    return rr.Transform3D(translation=pose.position, quaternion=orientation)


def boxes(
    cuboids: Sequence[Cuboid], labels: Sequence[str], colors: Sequence[RGB], *, solid: bool = False
) -> rr.Boxes3D:
    """Cuboids, each with a colour and a label that shows on hovering; as wireframes, or `solid`."""
    fill = rr.components.FillMode
    return rr.Boxes3D(
        centers=np.reshape([cuboid.pose.position for cuboid in cuboids], (-1, 3)),
        sizes=np.reshape([cuboid.edges_m for cuboid in cuboids], (-1, 3)),
        quaternions=np.reshape([cuboid.pose.orientation for cuboid in cuboids], (-1, 4)),
        colors=np.reshape(colors, (-1, 3)),
        labels=labels,
        show_labels=False,
        fill_mode=fill.Solid if solid else fill.MajorWireframe,
    )
