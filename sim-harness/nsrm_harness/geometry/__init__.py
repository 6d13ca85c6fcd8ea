"""Poses, cuboids, the pinhole camera and the shape of the Panda, without simulator or learning."""
