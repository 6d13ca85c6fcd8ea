"""Trials of a robot's processes: what they wrote down, read and judged apart from them."""
