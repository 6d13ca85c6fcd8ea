"""Simulates the tabletop in PyBullet: blocks, physics, the Panda, renderers."""
