"""Measures the detector against the boxes of the simulator's mask."""
