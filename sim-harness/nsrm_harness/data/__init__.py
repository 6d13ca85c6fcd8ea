"""Episodes: demonstrated in simulation, kept in files, read by the trainer."""
