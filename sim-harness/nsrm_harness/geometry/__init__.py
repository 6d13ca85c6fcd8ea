"""Poses, boxes, the pinhole camera and the shape of the Panda: no simulator, no learning."""
