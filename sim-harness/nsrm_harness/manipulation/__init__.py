"""Manipulation with the arm: grasps, paths, trajectories, collision checks, pick and place.

Nothing here depends on the simulator: the state of the world comes from images, and that of the arm
from its joints.
"""
