"""Measures how fast trials of the arm run, with how many workers, and where their time goes."""
