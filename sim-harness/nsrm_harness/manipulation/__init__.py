"""The arm: what it can reach, how it moves, what it would touch, and how it grasps.

Nothing here knows the simulator: what is known of the world comes from pictures, and what
is known of the arm from its joints.
"""
