"""Where pictures come from: a camera in the simulator or a real one, handed in by who has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.geometry.camera import Camera


@dataclass(frozen=True, eq=False)
class RgbdImage:
    """One picture in colour and depth; row 0 is the top.

    * `rgb`: `uint8 [H, W, 3]`; `depth`: `float32 [H, W]`, metres along the optical axis
    * `taken_s`: when, by the source's clock
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    taken_s: float


class CameraSource(Protocol):
    """A calibrated camera that takes pictures."""

    @property
    def camera(self) -> Camera:
        """Its calibration."""
        ...

    @property
    def now_s(self) -> float:
        """The time, by the clock that pictures are stamped with."""
        ...

    def take(self) -> RgbdImage:
        """A picture that is taken now, or the latest that there is."""
        ...
