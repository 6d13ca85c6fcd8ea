"""A robot's processes on the simulator's side: its camera, its controller, its world."""
