"""The light model: one distant lamp and uniform ambient light."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nsrm_harness.geometry.pose import Vector3


@dataclass(frozen=True)
class Light:
    """A surface with colour c and normal n appears as c · (ambient + diffuse · color · max(0,
    n·l)).

    * `direction`: l, unit vector towards the lamp, world frame
    * `ambient`, `diffuse`: intensities, with a sum of about 1
    * `color`: colour of the lamp, near (1, 1, 1)
    """

    direction: Vector3 = (0.36, -0.48, 0.80)
    ambient: float = 0.48
    diffuse: float = 0.60
    color: Vector3 = (1.0, 1.0, 1.0)

    @staticmethod
    def sample(rng: np.random.Generator) -> Light:
        """Draws a lamp above and on the camera's side, with random intensity and a
        warm to cool colour."""
        azimuth = math.radians(float(rng.uniform(-80.0, 80.0)))
        elevation = math.radians(float(rng.uniform(45.0, 75.0)))
        warmth = float(rng.uniform(-0.06, 0.06))
        return Light(
            direction=(
                math.cos(elevation) * math.cos(azimuth),
                math.cos(elevation) * math.sin(azimuth),
                math.sin(elevation),
            ),
            ambient=float(rng.uniform(0.40, 0.55)),
            diffuse=float(rng.uniform(0.48, 0.66)),
            color=(1.0 + warmth, 1.0, 1.0 - warmth),
        )

    def shade(self, normal: Vector3) -> tuple[float, float, float]:
        """Factors on red, green and blue for a surface with this normal."""
        facing = max(0.0, sum(n * d for n, d in zip(normal, self.direction, strict=True)))
        red, green, blue = (self.ambient + self.diffuse * facing * c for c in self.color)
        return (red, green, blue)
