"""The Franka Panda and its hand: the manufacturer's limits, and their shape.

Source of all limits: Franka Emika, "Control parameters specifications" (Panda) and "Panda's
instruction handbook", the hand's data.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet_data
from numpy.typing import NDArray

# Only the description: it loads nothing of the simulator.
URDF = Path(pybullet_data.getDataPath()) / "franka_panda" / "panda.urdf"

JOINTS = 7
"""Number of joints of the arm, all revolute."""

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
"""The manufacturer's "ready" pose, outside the camera's view of the workspace."""

HAND_FRAME = "panda_hand"
"""The frame of the hand in the URDF: z points along the fingers, which move along y."""
FINGERTIP_M = 0.1122
"""Distance of the fingertips along the hand's z."""
FINGERS = ("panda_leftfinger", "panda_rightfinger")
"""The links of the fingers in the URDF."""
MAX_OPENING_M = 0.08
"""Largest opening between the fingers."""
FINGER_SPEED_M_S = 0.05
"""Largest speed of each finger."""
GRIP_N = 40.0
"""Grasp force; the hand allows up to 70 N continuously. A block that is lowered onto another one
must not slide up between the fingers before the joints detect the contact."""
MAX_TORQUE_NM = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
"""Largest torque of each joint's motor."""
