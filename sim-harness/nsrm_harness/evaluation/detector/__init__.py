"""How well the detector finds blocks, against the boxes of the simulator's mask."""
