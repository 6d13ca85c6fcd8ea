"""The interface of a camera, simulated or real, which the caller passes to perception."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import Camera


@dataclass(frozen=True, eq=False)
class RgbdImage:
    """One image in colour and depth; row 0 is the top.

    * `rgb`: `uint8 [H, W, 3]`; `depth`: `float32 [H, W]`, metres along the optical axis
    * `taken_s`: when it was taken, by the source's clock
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    taken_s: float


class CameraSource(Protocol):
    """A calibrated camera that takes images."""

    @property
    def camera(self) -> Camera:
        """The camera's calibration."""
        ...

    @property
    def now_s(self) -> float:
        """The time, by the clock that stamps images."""
        ...

    def take(self) -> RgbdImage:
        """Takes an image now, or returns the latest one."""
        ...
