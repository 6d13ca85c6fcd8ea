"""Episodes: demonstrated in simulation, stored in files, and read by the trainer."""
