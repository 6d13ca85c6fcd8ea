"""Finds and tracks objects in colour and depth images, without the simulator's mask."""
