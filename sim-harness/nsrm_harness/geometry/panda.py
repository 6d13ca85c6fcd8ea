"""The Franka Panda and its hand: what their maker allows, and their shape.

Source of all limits: Franka Emika, "Control parameters specifications" (Panda) and "Panda's
instruction handbook", the hand's data.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet_data
from numpy.typing import NDArray

# The description alone: nothing of the simulator is loaded with it.
URDF = Path(pybullet_data.getDataPath()) / "franka_panda" / "panda.urdf"

JOINTS = 7
"""The arm's, all of them revolute."""

LOWEST_RAD: NDArray[np.float64] = np.array(
    [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]
)
HIGHEST_RAD: NDArray[np.float64] = np.array(
    [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]
)
MAX_SPEED_RAD_S: NDArray[np.float64] = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
MAX_ACCELERATION_RAD_S2: NDArray[np.float64] = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
MAX_JERK_RAD_S3: NDArray[np.float64] = np.array(
    [7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0]
)

READY_RAD: NDArray[np.float64] = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
"""The maker's "ready" pose, out of the camera's view of the work space."""

HAND_FRAME = "panda_hand"
"""The frame of the hand in the URDF: z along the fingers, y along which they move."""
FINGERTIP_M = 0.1122
"""Of the fingers' ends along the hand's z."""
FINGERS = ("panda_leftfinger", "panda_rightfinger")
"""Their links in the URDF."""
MAX_OPENING_M = 0.08
"""Between the fingers."""
FINGER_SPEED_M_S = 0.05
"""Of each finger, at most."""
GRIP_N = 40.0
"""With which the fingers hold; the hand may hold with up to 70 N lastingly. A block that is lowered
onto another one must not slide up between them before the joints feel it."""
MAX_TORQUE_NM = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
"""The most that each joint's motor gives."""
