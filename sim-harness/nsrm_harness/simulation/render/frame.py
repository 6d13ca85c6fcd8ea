"""The output of a renderer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The visible surfaces, without colours; row 0 is the top.

    * `depth`: `float32 [H, W]`, metres along the optical axis, at the pixels' centres
    * `mask`: `int32 [H, W]`, id of the block at the pixel's centre, 0 for none
    """

    depth: NDArray[np.float32]
    mask: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Frame(Surfaces):
    """An image in colour, depth and ids; row 0 is the top.

    * `rgb`: `uint8 [H, W, 3]`, anti-aliased
    """

    rgb: NDArray[np.uint8]
