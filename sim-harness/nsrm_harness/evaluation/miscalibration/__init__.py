"""Measures how the core detects miscalibrated cameras."""
