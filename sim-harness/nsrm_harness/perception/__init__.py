"""Perception: objects from a colour and a depth image, without the simulator's mask."""
